//! What the program tells its user: short notices that go by themselves, errors that stay until closed, and
//! the history of both behind the bell.

use std::time::Duration;

/// How long a notice stays; the same as Rerun's.
const SHOWN: Duration = Duration::from_secs(4);
/// Notices kept for the history.
const KEPT: usize = 200;

/// How serious a notice is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Level {
    /// Something happened as wanted.
    Info,
    /// Something was left out or guessed.
    Warning,
    /// Something could not be done; stays until closed.
    Error,
}

/// One message.
#[derive(Clone, Debug, PartialEq)]
pub struct Notice {
    /// How serious it is.
    pub level: Level,
    /// One sentence.
    pub text: String,
    /// More for those who want it: file, place, remedy. May be empty.
    pub details: String,
    /// Still shown over the window.
    pub shown: bool,
    age: Duration,
}

impl Notice {
    /// Everything, as it goes to the clipboard.
    pub fn for_clipboard(&self) -> String {
        if self.details.is_empty() { self.text.clone() } else { format!("{}\n{}", self.text, self.details) }
    }

    /// How much of its time is left, 1 to 0; errors stay at 1.
    pub fn freshness(&self) -> f32 {
        if self.level == Level::Error {
            return 1.0;
        }
        1.0 - (self.age.as_secs_f32() / SHOWN.as_secs_f32()).min(1.0)
    }
}

/// All messages, the newest last.
#[derive(Clone, Debug, Default)]
pub struct Notices {
    list: Vec<Notice>,
    unread: usize,
}

impl Notices {
    /// Says that something went well.
    pub fn info(&mut self, text: impl Into<String>) {
        self.add(Level::Info, text.into(), String::new());
    }

    /// Says that something was left out.
    pub fn warning(&mut self, text: impl Into<String>) {
        self.add(Level::Warning, text.into(), String::new());
    }

    /// Says that something could not be done.
    pub fn error(&mut self, text: impl Into<String>, details: impl Into<String>) {
        self.add(Level::Error, text.into(), details.into());
    }

    fn add(&mut self, level: Level, text: String, details: String) {
        self.list.retain(|old| !(old.shown && old.text == text && old.details == details));
        self.list.push(Notice { level, text, details, shown: true, age: Duration::ZERO });
        self.unread += 1;
        if self.list.len() > KEPT {
            self.list.remove(0);
        }
    }

    /// Lets time pass; notices older than four seconds go, errors stay.
    /// Returns when the next one will go.
    pub fn advance(&mut self, passed: Duration) -> Option<Duration> {
        let mut next = None;
        for notice in self.list.iter_mut().filter(|n| n.shown && n.level != Level::Error) {
            notice.age += passed;
            notice.shown = notice.age < SHOWN;
            if notice.shown {
                let left = SHOWN.saturating_sub(notice.age);
                next = Some(next.map_or(left, |n: Duration| n.min(left)));
            }
        }
        next
    }

    /// Every message with its number for [`Notices::close`], the oldest first.
    pub fn all(&self) -> impl DoubleEndedIterator<Item = (usize, &Notice)> {
        self.list.iter().enumerate()
    }

    /// Takes a message off the window; it stays in the history.
    pub fn close(&mut self, number: usize) {
        if let Some(notice) = self.list.get_mut(number) {
            notice.shown = false;
        }
    }

    /// Takes all but errors off the window.
    pub fn hide_news(&mut self) {
        self.list.iter_mut().filter(|n| n.level != Level::Error).for_each(|n| n.shown = false);
    }

    /// Messages since the history was last looked at.
    pub fn unread(&self) -> usize {
        self.unread
    }

    /// The history was looked at.
    pub fn mark_read(&mut self) {
        self.unread = 0;
    }

    /// Forgets everything.
    pub fn clear(&mut self) {
        self.list.clear();
        self.unread = 0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shown(notices: &Notices) -> Vec<&str> {
        notices.all().filter(|(_, n)| n.shown).map(|(_, n)| n.text.as_str()).collect()
    }

    #[test]
    fn news_go_after_four_seconds_and_errors_stay_until_closed() {
        let mut notices = Notices::default();
        notices.info("Saved");
        notices.error("The room can't be read", "room.glb: truncated");
        notices.advance(Duration::from_secs(3));
        assert_eq!(shown(&notices), ["Saved", "The room can't be read"]);
        notices.advance(Duration::from_secs(2));
        assert_eq!(shown(&notices), ["The room can't be read"]);
        notices.close(1);
        assert!(shown(&notices).is_empty());
        assert_eq!(notices.all().count(), 2, "both stay in the history");
    }

    #[test]
    fn the_same_message_twice_is_shown_once() {
        let mut notices = Notices::default();
        notices.error("No", "why");
        notices.error("No", "why");
        assert_eq!(shown(&notices).len(), 1);
    }
}
