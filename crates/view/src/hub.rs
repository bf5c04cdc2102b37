//! Where what is shown and the pages meet.

use crate::mailbox::Mailbox;
use crate::order::Order;
use crate::wish::PictureWish;
use std::collections::BTreeMap;
use std::sync::mpsc::SyncSender;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use tungstenite::Bytes;

/// Number of a page, in the order of coming.
pub(crate) type PageId = u64;

/// Something that happens at a page.
#[derive(Debug, PartialEq)]
pub(crate) enum Event {
    /// It came, went, or took the controls.
    Pages,
    /// It asks for something, and is at the controls.
    Order(Order),
    /// It wishes for a picture, or for no more of one.
    Picture(PageId, Option<PictureWish>),
    /// The server ends.
    End,
}

/// All pages.
#[derive(Debug)]
pub(crate) struct Hub {
    pages: Mutex<Pages>,
    events: SyncSender<Event>,
}

#[derive(Debug, Default)]
struct Pages {
    mailboxes: BTreeMap<PageId, Arc<Mailbox>>,
    next: PageId,
    /// Which page may change something.
    controls: Option<PageId>,
    /// What a page that comes needs to know.
    about: Option<Arc<str>>,
    layout: Option<Bytes>,
    frame: Option<Bytes>,
    state: Option<Arc<str>>,
    ended: bool,
}

impl Hub {
    pub(crate) fn new(events: SyncSender<Event>) -> Self {
        Self { pages: Mutex::default(), events }
    }

    fn pages(&self) -> MutexGuard<'_, Pages> {
        self.pages.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A page comes; none may once the server ends, or if there are as many as `most`.
    pub(crate) fn join(&self, most: usize) -> Option<(PageId, Arc<Mailbox>)> {
        let mut pages = self.pages();
        if pages.ended || pages.mailboxes.len() >= most {
            return None;
        }
        let (page, mailbox) = (pages.next, Arc::new(Mailbox::default()));
        pages.next += 1;
        pages.about.iter().for_each(|about| mailbox.put_about(about));
        pages.layout.iter().for_each(|layout| mailbox.put_layout(layout));
        pages.state.iter().for_each(|state| mailbox.put_state(state));
        pages.frame.iter().for_each(|frame| mailbox.put_frame(frame));
        pages.mailboxes.insert(page, Arc::clone(&mailbox));
        pages.controls.get_or_insert(page);
        pages.tell_who_controls();
        drop(pages);
        self.tell(Event::Pages);
        Some((page, mailbox))
    }

    /// A page goes; the one that came first of the others takes the controls, if it had them.
    pub(crate) fn leave(&self, page: PageId) {
        let mut pages = self.pages();
        if let Some(mailbox) = pages.mailboxes.remove(&page) {
            mailbox.end();
        }
        let lost = pages.controls == Some(page);
        if lost {
            pages.controls = pages.mailboxes.keys().next().copied();
        }
        pages.tell_who_controls();
        drop(pages);
        if lost {
            // Nobody is left who could let go.
            self.tell(Event::Order(Order::Drop));
        }
        self.tell(Event::Pages);
    }

    /// A page asks for something. Waits while too much has been asked for that is not done yet.
    pub(crate) fn ask(&self, page: PageId, order: Order) {
        let mut pages = self.pages();
        match order {
            Order::Drawn { frames } => {
                if let Some(mailbox) = pages.mailboxes.get(&page) {
                    mailbox.drawn(frames);
                }
                drop(pages);
                self.tell(Event::Pages);
            }
            Order::Control => {
                pages.controls = Some(page);
                pages.tell_who_controls();
            }
            // Whoever only looks may look at it so.
            Order::Picture(wish) => {
                drop(pages);
                self.tell(Event::Picture(page, Some(wish)));
            }
            Order::EndPicture => {
                drop(pages);
                self.tell(Event::Picture(page, None));
            }
            order => {
                let may = pages.controls == Some(page);
                drop(pages);
                if may {
                    self.tell(Event::Order(order));
                }
            }
        }
    }

    fn tell(&self, event: Event) {
        // Whoever listened has gone only when all ends.
        if event == Event::Pages {
            let _ = self.events.try_send(event);
        } else {
            let _ = self.events.send(event);
        }
    }

    pub(crate) fn count(&self) -> usize {
        self.pages().mailboxes.len()
    }

    /// Whether a page waits for a frame.
    pub(crate) fn wants_frame(&self) -> bool {
        self.pages().mailboxes.values().any(|mailbox| mailbox.wants_frame())
    }

    /// Says what is shown from now on: a text, and what does not change from frame to frame.
    pub(crate) fn show(&self, about: &str, layout: Option<Vec<u8>>) {
        let mut pages = self.pages();
        let about: Arc<str> = about.into();
        let layout: Option<Bytes> = layout.map(Into::into);
        for mailbox in pages.mailboxes.values() {
            mailbox.put_about(&about);
            layout.iter().for_each(|layout| mailbox.put_layout(layout));
        }
        (pages.about, pages.state) = (Some(about), None);
        if layout.is_some() {
            (pages.layout, pages.frame) = (layout, None);
        }
    }

    pub(crate) fn publish_state(&self, state: &str) {
        let mut pages = self.pages();
        let state: Arc<str> = state.into();
        pages.mailboxes.values().for_each(|mailbox| mailbox.put_state(&state));
        pages.state = Some(state);
    }

    /// Gives a frame to the pages that wait for one.
    pub(crate) fn publish_frame(&self, frame: Vec<u8>) {
        let mut pages = self.pages();
        let frame: Bytes = frame.into();
        let waiting = pages.mailboxes.values().filter(|mailbox| mailbox.wants_frame());
        waiting.for_each(|mailbox| mailbox.put_frame(&frame));
        pages.frame = Some(frame);
    }

    /// Tells all pages something once.
    pub(crate) fn note(&self, note: &str) {
        let note: Arc<str> = note.into();
        self.pages().mailboxes.values().for_each(|mailbox| mailbox.put_note(&note));
    }

    /// Tells a page something once.
    pub(crate) fn note_to(&self, page: PageId, note: &str) {
        if let Some(mailbox) = self.pages().mailboxes.get(&page) {
            mailbox.put_note(&note.into());
        }
    }

    /// Gives a picture to a page; false if it has gone.
    pub(crate) fn send_picture(&self, page: PageId, picture: Vec<u8>) -> bool {
        let pages = self.pages();
        let mailbox = pages.mailboxes.get(&page);
        mailbox.iter().for_each(|mailbox| mailbox.put_picture(picture.clone()));
        mailbox.is_some()
    }

    /// Sends all pages away, and whoever listens too.
    pub(crate) fn end(&self) {
        let mut pages = self.pages();
        pages.ended = true;
        pages.mailboxes.values().for_each(|mailbox| mailbox.end());
        drop(pages);
        let _ = self.events.try_send(Event::End);
    }

    pub(crate) fn has_ended(&self) -> bool {
        self.pages().ended
    }
}

impl Pages {
    fn tell_who_controls(&self) {
        for (page, mailbox) in &self.mailboxes {
            let mine = self.controls == Some(*page);
            let pages = self.mailboxes.len();
            let note = format!(r#"{{"is":"controls","mine":{mine},"pages":{pages}}}"#);
            mailbox.put_note(&note.into());
        }
    }
}
