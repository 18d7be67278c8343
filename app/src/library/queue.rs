//! What a thread is to do next.

use std::collections::VecDeque;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

/// Orders that the newest ones replace.
pub(super) struct Queue<T> {
    orders: Mutex<(VecDeque<T>, bool)>,
    changed: Condvar,
}

impl<T> Default for Queue<T> {
    fn default() -> Self {
        Self { orders: Mutex::default(), changed: Condvar::new() }
    }
}

impl<T> Queue<T> {
    fn lock(&self) -> MutexGuard<'_, (VecDeque<T>, bool)> {
        self.orders.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Puts these in the place of all orders.
    pub fn set(&self, orders: VecDeque<T>) {
        self.lock().0 = orders;
        self.changed.notify_one();
    }

    /// Ends everybody who waits.
    pub fn close(&self) {
        *self.lock() = (VecDeque::new(), true);
        self.changed.notify_all();
    }

    /// The next order, when there is one; `None` once nobody orders any more.
    pub fn next(&self) -> Option<T> {
        let mut orders = self.lock();
        loop {
            if orders.1 {
                return None;
            }
            match orders.0.pop_front() {
                Some(order) => return Some(order),
                None => orders = self.changed.wait(orders).unwrap_or_else(PoisonError::into_inner),
            }
        }
    }
}
