//! The editor's window: panels, viewport, tools, commands, jobs, notifications. The only place that names
//! egui. Sends intents to the document and never edits the scene in place; never names `cli`.
