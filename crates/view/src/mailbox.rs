//! What is on its way to one page: bounded, the newest in place of what has not been sent yet.

use std::collections::VecDeque;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;
use tungstenite::Bytes;

/// Frames that a page may have been sent without having said that it drew them.
const AHEAD: u32 = 2;
/// Notes that wait at most; the oldest is left out.
const MOST_NOTES: usize = 16;

/// Something that is sent.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Letter {
    Text(Arc<str>),
    Bytes(Bytes),
    /// Nothing came for a while: time to ask whether the page is still there.
    Nothing,
    /// No more will come.
    End,
}

/// What has not been sent yet.
#[derive(Debug, Default)]
struct Mail {
    /// What is shown: its title, sliders and so on.
    about: Option<Arc<str>>,
    /// What does not change from frame to frame.
    layout: Option<Bytes>,
    state: Option<Arc<str>>,
    frame: Option<Bytes>,
    /// A picture by paths of light.
    picture: Option<Bytes>,
    notes: VecDeque<Arc<str>>,
    /// Frames sent, less those that the page has drawn.
    ahead: u32,
    ended: bool,
}

/// The letters to one page.
#[derive(Debug, Default)]
pub(crate) struct Mailbox {
    mail: Mutex<Mail>,
    news: Condvar,
}

impl Mailbox {
    fn mail(&self) -> MutexGuard<'_, Mail> {
        self.mail.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn change(&self, with: impl FnOnce(&mut Mail)) {
        with(&mut self.mail());
        self.news.notify_one();
    }

    /// Says what is shown from now on; how it stood before is told no more.
    pub(crate) fn put_about(&self, about: &Arc<str>) {
        self.change(|mail| {
            mail.about = Some(Arc::clone(about));
            mail.state = None;
        });
    }

    /// Puts another layout; frames of the one before fit it no more.
    pub(crate) fn put_layout(&self, layout: &Bytes) {
        self.change(|mail| {
            mail.layout = Some(layout.clone());
            mail.frame = None;
        });
    }

    pub(crate) fn put_state(&self, state: &Arc<str>) {
        self.change(|mail| mail.state = Some(Arc::clone(state)));
    }

    pub(crate) fn put_frame(&self, frame: &Bytes) {
        self.change(|mail| mail.frame = Some(frame.clone()));
    }

    /// Puts a picture in place of an older one.
    pub(crate) fn put_picture(&self, picture: Vec<u8>) {
        self.change(|mail| mail.picture = Some(picture.into()));
    }

    pub(crate) fn put_note(&self, note: &Arc<str>) {
        self.change(|mail| {
            if mail.notes.len() == MOST_NOTES {
                mail.notes.pop_front();
            }
            mail.notes.push_back(Arc::clone(note));
        });
    }

    /// Whether a frame put now would soon be sent.
    pub(crate) fn wants_frame(&self) -> bool {
        let mail = self.mail();
        mail.frame.is_none() && mail.ahead < AHEAD
    }

    /// Takes note that the page has drawn the last of some frames, and needs the others no more.
    pub(crate) fn drawn(&self, frames: u32) {
        self.change(|mail| mail.ahead = mail.ahead.saturating_sub(frames));
    }

    /// Ends all sending.
    pub(crate) fn end(&self) {
        self.change(|mail| mail.ended = true);
    }

    /// The next letter, waiting for one as long as `patience`.
    pub(crate) fn next(&self, patience: Duration) -> Letter {
        let is_empty = |mail: &mut Mail| {
            let frame = mail.frame.is_some() && mail.ahead < AHEAD;
            let texts = mail.about.is_some() || mail.state.is_some() || !mail.notes.is_empty();
            let bytes = mail.layout.is_some() || mail.picture.is_some();
            !(mail.ended || texts || frame || bytes)
        };
        let waited = self.news.wait_timeout_while(self.mail(), patience, is_empty);
        let (mut mail, _) = waited.unwrap_or_else(PoisonError::into_inner);
        if mail.ended {
            return Letter::End;
        }
        let notes = &mut mail.notes;
        if let Some(text) = notes.pop_front() {
            return Letter::Text(text);
        }
        if let Some(text) = mail.about.take() {
            return Letter::Text(text);
        }
        if let Some(bytes) = mail.layout.take() {
            return Letter::Bytes(bytes);
        }
        if let Some(text) = mail.state.take() {
            return Letter::Text(text);
        }
        if let Some(bytes) = mail.picture.take() {
            return Letter::Bytes(bytes);
        }
        if mail.ahead < AHEAD
            && let Some(bytes) = mail.frame.take()
        {
            mail.ahead += 1;
            return Letter::Bytes(bytes);
        }
        Letter::Nothing
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bytes(of: u8) -> Bytes {
        Bytes::copy_from_slice(&[of])
    }

    #[test]
    fn a_page_that_draws_nothing_gets_two_frames_and_then_the_newest() {
        let (mailbox, soon) = (Mailbox::default(), Duration::from_millis(1));
        for number in [1, 2] {
            assert!(mailbox.wants_frame());
            mailbox.put_frame(&bytes(number));
            assert_eq!(mailbox.next(soon), Letter::Bytes(bytes(number)));
        }
        assert!(!mailbox.wants_frame());
        mailbox.put_frame(&bytes(5));
        mailbox.put_frame(&bytes(6));
        assert_eq!(mailbox.next(soon), Letter::Nothing);
        mailbox.drawn(1);
        assert_eq!(mailbox.next(soon), Letter::Bytes(bytes(6)));
    }

    #[test]
    fn of_two_frames_that_came_together_both_are_done_when_the_last_is_drawn() {
        let (mailbox, soon) = (Mailbox::default(), Duration::from_millis(1));
        for round in 0..5 {
            for number in [2 * round, 2 * round + 1] {
                assert!(mailbox.wants_frame(), "{number}");
                mailbox.put_frame(&bytes(number));
                assert_eq!(mailbox.next(soon), Letter::Bytes(bytes(number)));
            }
            assert!(!mailbox.wants_frame());
            mailbox.drawn(2);
        }
        // A page that says too much gets no more than others.
        mailbox.drawn(u32::MAX);
        for number in [20, 21] {
            mailbox.put_frame(&bytes(number));
            assert_eq!(mailbox.next(soon), Letter::Bytes(bytes(number)));
        }
        assert!(!mailbox.wants_frame());
    }

    #[test]
    fn a_layout_comes_before_its_frames_and_without_those_of_another() {
        let (mailbox, soon) = (Mailbox::default(), Duration::from_millis(1));
        mailbox.put_frame(&bytes(1));
        mailbox.put_layout(&bytes(2));
        mailbox.put_frame(&bytes(3));
        assert_eq!(mailbox.next(soon), Letter::Bytes(bytes(2)));
        assert_eq!(mailbox.next(soon), Letter::Bytes(bytes(3)));
    }

    #[test]
    fn what_is_shown_is_told_without_the_state_of_another() {
        let (mailbox, soon) = (Mailbox::default(), Duration::from_millis(1));
        let [old, about, new] = ["old", "about", "new"].map(Arc::from);
        mailbox.put_state(&old);
        mailbox.put_about(&about);
        assert_eq!(mailbox.next(soon), Letter::Text(about));
        assert_eq!(mailbox.next(soon), Letter::Nothing);
        mailbox.put_state(&new);
        assert_eq!(mailbox.next(soon), Letter::Text(new));
    }

    #[test]
    fn notes_are_few() {
        let mailbox = Mailbox::default();
        for number in 0..100 {
            mailbox.put_note(&Arc::from(number.to_string()));
        }
        let mut count = 0;
        while mailbox.next(Duration::ZERO) != Letter::Nothing {
            count += 1;
        }
        assert_eq!(count, MOST_NOTES);
    }
}
