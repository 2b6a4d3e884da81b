//! The bundled models by what they are for. Sizes are those of the files (a test compares them).

/// A model file and its size: width, height, depth in metres.
#[derive(Clone, Copy, Debug)]
pub struct Stock {
    pub file: &'static str,
    pub size: (f32, f32, f32),
    /// Whether a colour over it looks right: it is light and of one piece.
    pub pale: bool,
}

const fn model(file: &'static str, width: f32, height: f32, depth: f32) -> Stock {
    Stock { file, size: (width, height, depth), pale: false }
}

const fn pale(file: &'static str, width: f32, height: f32, depth: f32) -> Stock {
    Stock { file, size: (width, height, depth), pale: true }
}

/// Straight sofas.
pub const SOFAS: &[Stock] = &[
    pale("couch__clear_sofa__Scopia.glb", 1.939, 0.8, 0.759),
    pale("couch__mid-century-sofa__KatorLegaz.glb", 1.99, 0.8, 0.84),
    model("couch__futon-couch__KatorLegaz.glb", 1.96, 0.878, 0.898),
    model("couch__mid-century-bench-sofa__KatorLegaz.glb", 2.789, 0.75, 1.073),
    model("couch__simple_sofa__Scopia.glb", 1.798, 0.95, 0.673),
    model("couch__burlap_sofa__Scopia.glb", 1.7, 0.797, 0.9),
    model("couch__sofa_white_beige__Scopia.glb", 1.738, 0.85, 0.816),
    model("couch__sofa2__BlendSwap-CC-0.glb", 1.669, 0.848, 0.747),
    model("couch__convertible-sofa-BZ-closed__Scopia.glb", 1.432, 0.873, 1.023),
    pale("couch__day_bed_frame__Scopia.glb", 2.08, 0.7, 0.97),
];

/// Sofas around a corner.
pub const CORNER_SOFAS: &[Stock] = &[
    model("couch__couch2__BlendSwap-CC-0.glb", 2.3, 0.866, 1.597),
    model("couch__sofa__BlendSwap-CC-0.glb", 2.488, 0.78, 1.896),
    model("couch__cornerSofa__BlendSwap-CC-BY.glb", 3.458, 0.855, 1.55),
];

/// Armchairs.
pub const ARMCHAIRS: &[Stock] = &[
    model("armchair__armchair2__BlendSwap-CC-0.glb", 0.953, 0.783, 0.833),
    model("armchair__fotel__BlendSwap-CC-BY.glb", 0.735, 0.697, 0.611),
    model("armchair__armChair2__BlendSwap-CC-BY.glb", 0.978, 0.885, 0.821),
    pale("armchair__mid-century-chair__KatorLegaz.glb", 0.735, 0.8, 0.844),
    model("armchair__armchair3__Scopia.glb", 0.591, 0.949, 0.694),
    model("armchair__armchair__Scopia.glb", 0.788, 1.001, 0.777),
    model("armchair__armchair1__Scopia.glb", 0.547, 0.9, 0.859),
    model("armchair__armchair1__BlendSwap-CC-BY.glb", 1.005, 0.8, 0.882),
    model("armchair__designChair__BlendSwap-CC-0.glb", 0.779, 0.994, 0.628),
];

/// Chairs for tables.
pub const CHAIRS: &[Stock] = &[
    model("chair__chair2__BlendSwap-CC-0.glb", 0.403, 0.868, 0.489),
    model("chair__chair3__BlendSwap-CC-BY.glb", 0.433, 0.906, 0.504),
    model("chair__plaidChair__BlendSwap-CC-BY.glb", 0.405, 0.8, 0.426),
    pale("chair__kitchenChair__BlendSwap-CC-BY.glb", 0.43, 0.91, 0.44),
    model("chair__dining-chair__KatorLegaz.glb", 0.423, 1.0, 0.573),
    model("chair__chair4__Scopia.glb", 0.484, 0.884, 0.442),
    model("chair__chair__Scopia.glb", 0.42, 0.88, 0.474),
    model("chair__chair3__Scopia.glb", 0.522, 0.859, 0.576),
    model("chair__osakaChair__BlendSwap-CC-0.glb", 0.475, 0.77, 0.525),
    pale("chair__white_kitchen_chair__Scopia.glb", 0.427, 0.86, 0.469),
    model("chair__tubular_chair__Scopia.glb", 0.532, 0.814, 0.499),
    model("chair__sillaBlanca__BlendSwap-CC-0.glb", 0.505, 0.85, 0.584),
    pale("chair__cafe_set_mota_chair__BlendSwap-CC-BY.glb", 0.609, 0.783, 0.558),
];

/// Chairs for desks.
pub const OFFICE_CHAIRS: &[Stock] = &[
    model("office_chair__office_chair__Scopia.glb", 0.635, 1.0, 0.637),
    model("office_chair__armchair__BlendSwap-CC-0.glb", 0.594, 1.05, 0.627),
];

/// High stools, seats at 0.6 to 0.8 m.
pub const BAR_STOOLS: &[Stock] = &[
    model("stool__kitchen_stool__Scopia.glb", 0.455, 0.984, 0.455),
    pale("stool__bar-stool__KatorLegaz.glb", 0.532, 1.1, 0.593),
    model("stool__bar_chair__Scopia.glb", 0.447, 1.078, 0.486),
    model("stool__stool2__BlendSwap-CC-0.glb", 0.361, 0.78, 0.361),
    model("stool__silla2__BlendSwap-CC-0.glb", 0.326, 0.788, 0.311),
];

/// Stools as high as chairs.
pub const LOW_STOOLS: &[Stock] = &[model("stool__green_stool__BlendSwap-CC-BY.glb", 0.429, 0.46, 0.429)];

/// Benches.
pub const BENCHES: &[Stock] = &[
    model("bench__bench__KatorLegaz.glb", 1.182, 0.45, 0.452),
    model("bench__bench__BlendSwap-CC-0.glb", 1.701, 0.508, 0.459),
];

/// Beds for two.
pub const BEDS: &[Stock] = &[
    model("bed__bed1__Scopia.glb", 1.705, 1.108, 2.165),
    model("bed__convertible-sofa-BZ-opened__Scopia.glb", 1.583, 0.478, 1.901),
];

/// Rectangular dining tables.
pub const TABLES: &[Stock] = &[
    model("dining_table__table4__Scopia.glb", 1.4, 0.75, 0.9),
    model("dining_table__table__BlendSwap-CC-0.glb", 2.35, 0.739, 1.0),
    model("dining_table__table__BlendSwap-CC-BY.glb", 1.443, 0.724, 0.934),
    model("dining_table__black_table__Scopia.glb", 1.701, 0.75, 0.9),
    model("dining_table__table-on-trestles__Scopia.glb", 1.6, 0.761, 0.664),
    model("dining_table__table-with-leaning-feet__Scopia.glb", 1.5, 0.75, 0.65),
    model("dining_table__white_kitchen_table__Scopia.glb", 1.1, 0.75, 0.701),
];

/// Round dining tables.
pub const ROUND_TABLES: &[Stock] = &[
    model("dining_table__oakTable__BlendSwap-CC-0.glb", 1.24, 0.741, 1.24),
    model("dining_table__round-table__Scopia.glb", 1.1, 0.757, 1.1),
];

/// High tables.
pub const BAR_TABLES: &[Stock] = &[model("bar_table__bar_table__Scopia.glb", 0.8, 1.024, 0.8)];

/// Coffee tables.
pub const COFFEE_TABLES: &[Stock] = &[
    model("coffee_table__coffeeTable__BlendSwap-CC-BY.glb", 1.2, 0.45, 0.701),
    model("coffee_table__table_wood_and_iron__Scopia.glb", 1.214, 0.503, 0.759),
    model("coffee_table__saloon_table__Scopia.glb", 1.439, 0.511, 0.641),
    model("coffee_table__living_room_table__Scopia.glb", 1.067, 0.536, 0.725),
    model("coffee_table__coffee-table2__Scopia.glb", 1.238, 0.477, 0.512),
];

/// Desks.
pub const DESKS: &[Stock] = &[
    model("office_desk__simpleDesk__BlendSwap-CC-BY.glb", 1.401, 0.72, 0.811),
    model("office_desk__wooden_office_pear_table_rect__Scopia.glb", 1.6, 0.754, 0.8),
    model("office_desk__wooden_office_alder_table__Scopia.glb", 1.615, 0.754, 0.942),
    model("office_desk__officeTable__BlendSwap-CC-BY.glb", 1.892, 0.751, 0.834),
];

/// Desks for children.
pub const KIDS_DESKS: &[Stock] = &[model("office_desk__kids_wooden_desk__Scopia.glb", 1.004, 0.746, 0.618)];

/// Chests of drawers.
pub const DRESSERS: &[Stock] =
    &[pale("drawers__dresserWithDrawers__BlendSwap-CC-BY.glb", 1.605, 0.81, 0.519)];

/// Filing cabinets.
pub const FILING: &[Stock] = &[model("drawers__filing-cabinet__KatorLegaz.glb", 0.386, 0.6, 0.526)];

/// Dressing tables.
pub const VANITIES: &[Stock] = &[model("dressing_table__dressing-table__Scopia.glb", 0.857, 1.359, 0.465)];

/// Wardrobes.
pub const WARDROBES: &[Stock] = &[
    pale("wardrobe__wardrobe2__BlendSwap-CC-BY.glb", 1.735, 2.08, 0.6),
    model("wardrobe__wardrobe__BlendSwap-CC-BY.glb", 0.921, 2.0, 0.68),
    model("wardrobe__wardrobe1__Scopia.glb", 2.174, 2.0, 0.53),
];

/// Nightstands.
pub const NIGHTSTANDS: &[Stock] = &[
    model("nightstand__bedsideTable2__BlendSwap-CC-0.glb", 0.486, 0.454, 0.481),
    model("nightstand__bedsideTable__BlendSwap-CC-BY.glb", 0.5, 0.48, 0.414),
];

/// Tall shelves.
pub const BOOKCASES: &[Stock] = &[
    model("bookcase__full-bookcase__KatorLegaz.glb", 0.898, 2.21, 0.347),
    model("bookcase__bookcase__BlendSwap-CC-0.glb", 0.919, 1.472, 0.365),
    model("bookcase__verticalShelves__BlendSwap-CC-0.glb", 0.44, 1.85, 0.39),
];

/// Shelves as high as a table.
pub const LOW_SHELVES: &[Stock] = &[model("bookcase__shelves__BlendSwap-CC-0.glb", 0.79, 0.79, 0.394)];

/// Shelves for children.
pub const KIDS_SHELVES: &[Stock] = &[model("bookcase__kids_shelves__Scopia.glb", 1.01, 1.907, 0.424)];

/// Kitchen counters of one module.
pub const COUNTERS: &[Stock] = &[
    model("kitchen_counter__lowerCabinet__BlendSwap-CC-0.glb", 0.6, 0.885, 0.612),
    model("kitchen_counter__drawersCabinet__BlendSwap-CC-0.glb", 0.6, 0.885, 0.612),
];

/// Kitchen sinks in a counter.
pub const SINKS: &[Stock] = &[model("kitchen_counter__sinkCabinet__BlendSwap-CC-0.glb", 0.6, 1.212, 0.612)];

/// Fridges.
pub const FRIDGES: &[Stock] = &[
    model("fridge__fridge__KatorLegaz.glb", 0.6, 1.262, 0.591),
    model("fridge__largeFridge__BlendSwap-CC-0.glb", 0.925, 1.843, 0.806),
];

/// Kitchen islands.
pub const ISLANDS: &[Stock] =
    &[model("kitchen_island__kitchenIsland__BlendSwap-CC-BY.glb", 0.939, 0.831, 0.699)];

/// TV stands.
pub const TV_STANDS: &[Stock] = &[model("tv_stand__tvStand__BlendSwap-CC-BY.glb", 1.351, 0.526, 0.465)];

/// Flat screens for a wall.
pub const TVS: &[Stock] = &[model("tv__wall-flat-tv__Scopia.glb", 1.028, 0.659, 0.109)];

/// Plants that stand on the floor.
pub const PLANTS: &[Stock] = &[model("plant__maceta__Scopia.glb", 0.59, 0.58, 0.65)];

/// Low tables for children.
pub const KIDS_TABLES: &[Stock] = &[model("table__children_table__Scopia.glb", 0.63, 0.45, 0.48)];

/// Low chairs for children.
pub const KIDS_CHAIRS: &[Stock] = &[model("chair__children_chair__Scopia.glb", 0.28, 0.51, 0.28)];

/// Large toys.
pub const TOYS: &[Stock] = &[model("toy__doll-house__Scopia.glb", 0.69, 0.868, 0.324)];

/// Shoes.
pub const SHOES: &[Stock] = &[model("shoes__sneakers__Scopia.glb", 0.283, 0.117, 0.356)];

/// What stands on tables where people eat.
pub const TABLEWARE: &[Stock] = &[
    model("plate__bread-plate__KatorLegaz.glb", 0.2, 0.022, 0.2),
    model("mug__coffee-mug__KatorLegaz.glb", 0.085, 0.108, 0.12),
    model("bowl__bowl__Scopia.glb", 0.401, 0.204, 0.401),
    model("glass__12-oz-glass__KatorLegaz.glb", 0.07, 0.097, 0.07),
    model("wine_bottle__wine_bottle__Scopia.glb", 0.078, 0.3, 0.078),
    model("bread__bread__BlendSwap-CC-0.glb", 0.216, 0.076, 0.147),
];

/// What stands on cabinets.
pub const DECORATION: &[Stock] = &[
    model("vase__jar__Scopia.glb", 0.244, 0.4, 0.244),
    model("vase__vase1__Scopia.glb", 0.227, 0.3, 0.227),
    model("vase__vase3__Scopia.glb", 0.235, 0.509, 0.235),
    model("potted_plant__littlePlant__BlendSwap-CC-0.glb", 0.266, 0.232, 0.266),
];

/// What lies on coffee tables and nightstands.
pub const SMALL_THINGS: &[Stock] = &[
    model("newspaper__newspaper__KatorLegaz.glb", 0.268, 0.02, 0.241),
    model("tablet__tablet__Scopia.glb", 0.17, 0.008, 0.24),
    model("remote_control__tv-remote-control__Scopia.glb", 0.045, 0.017, 0.18),
    model("mug__coffee-mug__KatorLegaz.glb", 0.085, 0.108, 0.12),
];

/// What lies on chests and shelves in bedrooms.
pub const LINEN: &[Stock] = &[model("folded_clothes__folded_clothes__Scopia.glb", 0.263, 0.122, 0.404)];

/// Lamps on desks.
pub const DESK_LAMPS: &[Stock] = &[model("desk_lamp__desklamp__BlendSwap-CC-0.glb", 0.244, 0.4, 0.244)];

/// Every list above.
#[cfg(test)]
pub const ALL: &[&[Stock]] = &[
    SOFAS,
    CORNER_SOFAS,
    ARMCHAIRS,
    CHAIRS,
    OFFICE_CHAIRS,
    BAR_STOOLS,
    LOW_STOOLS,
    BENCHES,
    BEDS,
    TABLES,
    ROUND_TABLES,
    BAR_TABLES,
    COFFEE_TABLES,
    DESKS,
    KIDS_DESKS,
    DRESSERS,
    FILING,
    VANITIES,
    WARDROBES,
    NIGHTSTANDS,
    BOOKCASES,
    LOW_SHELVES,
    KIDS_SHELVES,
    COUNTERS,
    SINKS,
    FRIDGES,
    ISLANDS,
    TV_STANDS,
    TVS,
    PLANTS,
    KIDS_TABLES,
    KIDS_CHAIRS,
    TOYS,
    SHOES,
    TABLEWARE,
    DECORATION,
    SMALL_THINGS,
    LINEN,
    DESK_LAMPS,
];
