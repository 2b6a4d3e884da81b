//! The rooms that come with the program, baked from `assets/rooms/*.layout.ron`.

/// A room that comes with the program.
#[derive(Clone, Copy, Debug)]
pub struct SampleRoom {
    /// Short name for the command line, such as `living`.
    pub key: &'static str,
    /// Name for people.
    pub title: &'static str,
    /// The room as GLB: metres, Y up, one node per object with its category in `extras`.
    pub glb: &'static [u8],
}

static ROOMS: [SampleRoom; 3] = [
    SampleRoom { key: "living", title: "Living room", glb: include_bytes!("../../assets/rooms/living.glb") },
    SampleRoom { key: "bedroom", title: "Bedroom", glb: include_bytes!("../../assets/rooms/bedroom.glb") },
    SampleRoom { key: "office", title: "Office", glb: include_bytes!("../../assets/rooms/office.glb") },
];

/// Every sample room, the one to open first at the front.
pub fn sample_rooms() -> &'static [SampleRoom] {
    &ROOMS
}
