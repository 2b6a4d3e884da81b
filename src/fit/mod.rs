//! Fits one body to a room by descent on energies. Pure: no files, no egui. May not name `generate` or
//! `motion`. Deterministic for a given start and configuration.
