//! The same jobs without a window: JSON reports, PNG pictures, exit codes. Never names `app`.
