//! Making small pictures for a window, on a thread of its own.

use super::slices::Slices;
use super::{Done, Key, New, Order, Purpose, Wake};
use crate::digest::Digest;
use crate::library::maker::{Limits, Renderer};
use crate::library::queue::Queue;
use crate::library::setup::{self, DEFAULT_SECONDS, DRAFT_SECONDS};
use crate::library::shelf::Shelf;
use crate::thumbnails::Thumbnail;
use burnish_renderer::path::StopReason;
use std::collections::HashSet;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::Sender;
use std::sync::{Arc, Mutex, PoisonError};

/// What the thread needs.
pub(super) struct PictureThread {
    pub renderer: Renderer,
    pub shelf: Option<Shelf>,
    pub queue: Arc<Queue<Order>>,
    pub may_make: Arc<Mutex<HashSet<Digest>>>,
    pub threads: Arc<AtomicUsize>,
    /// What was made: it may be ordered again before that is known there.
    pub made: HashSet<Key>,
    pub slices: Slices,
    pub sender: Sender<Done>,
    pub wake: Wake,
}

/// What became of an order.
pub(super) enum Outcome {
    /// There is something to tell.
    Done(Done),
    /// Its slice is over; the next is to come.
    PutAside,
    /// It is not wanted any more.
    Unwanted,
}

impl PictureThread {
    /// Makes pictures until nobody orders any more.
    pub fn run(mut self) {
        while let Some(due) = self.queue.next_by(|order| self.slices.rank(order)) {
            let place = self.renderer.root().join(&due.order.entry.path);
            let failed = |problem| Outcome::Done(Done::Failed(due.order.entry.look, format!("{}: {problem}", place.display())));
            match setup::guarded(|| self.make(&due.order)).unwrap_or_else(failed) {
                Outcome::Unwanted => {}
                Outcome::PutAside => self.queue.again(due),
                Outcome::Done(done) => {
                    if self.sender.send(done).is_err() {
                        return;
                    }
                    (self.wake)();
                }
            }
        }
    }

    /// Makes and keeps a picture, or a slice of it.
    pub fn make(&mut self, order: &Order) -> Result<Outcome, String> {
        let Order { entry, setup, purpose } = order;
        let may_make = self.may_make.clone();
        let is_wanted = |look: Digest| may_make.lock().unwrap_or_else(PoisonError::into_inner).contains(&look);
        let key = order.key();
        if self.made.contains(&key) || !is_wanted(entry.look) {
            return Ok(Outcome::Unwanted);
        }
        let (seconds, is_last) = match purpose {
            Purpose::Draft => (DRAFT_SECONDS, true),
            Purpose::Sight => self.slices.limit(key),
            Purpose::Batch => (DEFAULT_SECONDS, true),
        };
        let limits = Limits { seconds, threads: self.threads.load(Ordering::Relaxed) };
        let begun = self.slices.take_up(key);
        let (rendering, _) = self.renderer.render(setup, entry, begun, limits, &mut |_| is_wanted(entry.look))?;
        let is_draft = *purpose == Purpose::Draft;
        match rendering.stop_reason {
            StopReason::Cancelled if is_draft => return Ok(Outcome::Unwanted),
            StopReason::Cancelled => {
                self.slices.put_aside(key, &rendering, false, is_wanted);
                return Ok(Outcome::Unwanted);
            }
            StopReason::Time if !is_last => {
                self.slices.put_aside(key, &rendering, true, is_wanted);
                return Ok(Outcome::PutAside);
            }
            _ => {}
        }
        let made = setup.develop(&rendering)?;
        self.made.insert(key);
        if is_draft {
            self.slices.expect(entry.look, rendering.seconds, made.relmse);
        } else {
            self.slices.done(key);
        }
        let kept = self.shelf.as_mut().filter(|_| !is_draft).map(|shelf| shelf.put(key.0, key.1, &made.png));
        let problem = kept.and_then(|kept| kept.err().map(|error| error.to_string()));
        let frame = setup.frame();
        let rgba = made.rgb.as_chunks::<3>().0.iter().flat_map(|[r, g, b]| [*r, *g, *b, 255]).collect();
        let thumbnail = Thumbnail { width: frame.width as u32, height: frame.height as u32, rgba };
        let is_limited = made.stop_reason == StopReason::Time;
        Ok(Outcome::Done(Done::Made(Box::new(New { key, path: entry.path.clone(), thumbnail, is_limited, is_draft, problem }))))
    }
}
