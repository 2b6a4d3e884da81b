//! The only writer of the scene: Command (intent) to Change (fact), undo history, project files.
//!
//! May name `math`, `assets`, `scene`, `body`, `inspect`. Knows no job, no window and no generator.
