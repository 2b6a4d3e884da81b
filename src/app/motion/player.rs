//! What time it is in the motions that are shown.

/// Shortest and longest speed that can be chosen.
pub const SPEEDS: [f32; 5] = [0.1, 0.25, 0.5, 1.0, 2.0];

/// Plays, stops, goes on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Player {
    /// Since the beginning, seconds.
    pub seconds: f32,
    /// It goes on by itself.
    pub playing: bool,
    /// Begins again at the end.
    pub looping: bool,
    /// Seconds of motion in a second.
    pub speed: f32,
}

impl Default for Player {
    fn default() -> Self {
        Self { seconds: 0.0, playing: false, looping: true, speed: 1.0 }
    }
}

impl Player {
    /// `passed_s` seconds have gone by while motions of `length_s` seconds are shown.
    pub fn advance(&mut self, passed_s: f32, length_s: f32) {
        if length_s <= 0.0 {
            *self = Self { seconds: 0.0, playing: false, ..*self };
        }
        if !self.playing {
            return;
        }
        let seconds = self.seconds + passed_s.max(0.0) * self.speed;
        if seconds <= length_s {
            self.seconds = seconds;
        } else if self.looping {
            self.seconds = seconds.rem_euclid(length_s);
        } else {
            (self.seconds, self.playing) = (length_s, false);
        }
    }

    /// Plays, from the beginning if it is at the end; or stops.
    pub fn toggle(&mut self, length_s: f32) {
        self.playing = !self.playing && length_s > 0.0;
        if self.playing && self.seconds >= length_s {
            self.seconds = 0.0;
        }
    }

    /// Stops at a time.
    pub fn seek(&mut self, seconds: f32, length_s: f32) {
        self.seconds = seconds;
        self.playing = false;
        self.clamp(length_s);
    }

    /// Goes so many frames of `fps` on or back.
    pub fn step(&mut self, frames: i32, fps: f32, length_s: f32) {
        let frame = (self.seconds * fps).round() + frames as f32;
        self.seek(frame / fps, length_s);
    }

    /// Keeps the time within motions of `length_s` seconds.
    pub fn clamp(&mut self, length_s: f32) {
        self.seconds = self.seconds.clamp(0.0, length_s.max(0.0));
        self.playing &= length_s > 0.0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_loop_goes_round_and_without_it_the_end_is_the_end() {
        let mut player = Player { playing: true, speed: 2.0, ..Player::default() };
        player.advance(1.2, 2.0);
        assert!((player.seconds - 0.4).abs() < 1e-6 && player.playing, "2.4 s into 2 s");
        player.looping = false;
        player.advance(10.0, 2.0);
        assert_eq!((player.seconds, player.playing), (2.0, false));
        player.toggle(2.0);
        assert_eq!((player.seconds, player.playing), (0.0, true), "from the beginning again");
    }

    #[test]
    fn steps_land_on_whole_frames_and_stay_within() {
        let mut player = Player { seconds: 0.51, ..Player::default() };
        player.step(1, 30.0, 1.0);
        assert!((player.seconds - 16.0 / 30.0).abs() < 1e-6);
        player.step(-40, 30.0, 1.0);
        assert_eq!(player.seconds, 0.0);
        player.step(100, 30.0, 1.0);
        assert_eq!(player.seconds, 1.0);
    }

    #[test]
    fn nothing_plays_where_nothing_moves() {
        let mut player = Player::default();
        player.toggle(0.0);
        assert!(!player.playing);
        player.playing = true;
        player.advance(0.1, 0.0);
        assert_eq!((player.playing, player.seconds), (false, 0.0));
    }
}
