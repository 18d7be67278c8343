//! What a thread is to do next.

use std::collections::VecDeque;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

/// Orders that the newest ones replace.
pub(super) struct Queue<T> {
    state: Mutex<State<T>>,
    changed: Condvar,
}

struct State<T> {
    orders: VecDeque<T>,
    /// How often all orders were replaced.
    replaced: u64,
    is_closed: bool,
}

/// An order that is being carried out.
pub(super) struct Due<T> {
    pub order: T,
    replaced: u64,
}

impl<T> Default for Queue<T> {
    fn default() -> Self {
        let state = State { orders: VecDeque::new(), replaced: 0, is_closed: false };
        Self { state: Mutex::new(state), changed: Condvar::new() }
    }
}

impl<T> Queue<T> {
    fn lock(&self) -> MutexGuard<'_, State<T>> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Puts these in the place of all orders.
    pub fn set(&self, orders: VecDeque<T>) {
        let mut state = self.lock();
        state.orders = orders;
        state.replaced += 1;
        drop(state);
        self.changed.notify_one();
    }

    /// Ends everybody who waits.
    pub fn close(&self) {
        let mut state = self.lock();
        (state.orders, state.is_closed) = (VecDeque::new(), true);
        drop(state);
        self.changed.notify_all();
    }

    /// The first order, when there is one; `None` once nobody orders any more.
    pub fn next(&self) -> Option<T> {
        Some(self.next_by(|_| ())?.order)
    }

    /// The order of the lowest rank, the first of those that share it, when there is one; `None` once nobody orders any more.
    pub fn next_by<R: Ord>(&self, rank: impl Fn(&T) -> R) -> Option<Due<T>> {
        let mut state = self.lock();
        loop {
            if state.is_closed {
                return None;
            }
            let lowest = state.orders.iter().enumerate().min_by_key(|(_, order)| rank(order)).map(|(place, _)| place);
            match lowest.and_then(|place| state.orders.remove(place)) {
                Some(order) => return Some(Due { order, replaced: state.replaced }),
                None => state = self.changed.wait(state).unwrap_or_else(PoisonError::into_inner),
            }
        }
    }

    /// Takes back an order that is not done yet, behind the others; not where all orders were replaced since: the new ones name it again if it is
    /// still wanted.
    pub fn again(&self, due: Due<T>) {
        let mut state = self.lock();
        if state.replaced == due.replaced && !state.is_closed {
            state.orders.push_back(due.order);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lowest_rank_comes_first_and_nothing_waits_for_what_comes_again() {
        let queue = Queue::default();
        queue.set(VecDeque::from([("slow", 2), ("a", 1), ("b", 1)]));
        let mut done = Vec::new();
        let mut slices = 0;
        while done.len() < 3 {
            // What has had a slice comes after all that have not.
            let due = queue.next_by(|(name, rank)| (if *name == "slow" { slices } else { 0 }, *rank)).unwrap();
            match due.order {
                ("slow", _) if slices < 2 => {
                    slices += 1;
                    queue.again(due);
                }
                (name, _) => done.push(name),
            }
            if done.is_empty() {
                assert_eq!(slices, 0, "two of a lower rank are left");
            }
        }
        assert_eq!(done, ["a", "b", "slow"]);
        queue.set(VecDeque::from([("first", 0), ("second", 0)]));
        assert_eq!(queue.next().map(|(name, _)| name), Some("first"), "the first of equals");
    }

    #[test]
    fn orders_that_were_replaced_do_not_come_again() {
        let queue = Queue::default();
        queue.set(VecDeque::from([1, 2]));
        let due = queue.next_by(|x| *x).unwrap();
        queue.set(VecDeque::from([3]));
        queue.again(due);
        assert_eq!(queue.next(), Some(3));
        queue.set(VecDeque::from([4]));
        let due = queue.next_by(|x| *x).unwrap();
        queue.again(due);
        assert_eq!(queue.next(), Some(4));
        queue.set(VecDeque::from([5]));
        let due = queue.next_by(|x| *x).unwrap();
        queue.close();
        queue.again(due);
        assert_eq!(queue.next(), None);
    }
}
