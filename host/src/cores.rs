//! The same work on each of many things, on all cores.

use std::panic::resume_unwind;
use std::thread;

/// What `of` makes of each of `items`, in their order.
pub(crate) fn each<T: Sync, R: Send>(items: &[T], of: impl Fn(&T) -> R + Sync) -> Vec<R> {
    let cores = thread::available_parallelism().map_or(1, usize::from);
    let share = items.len().div_ceil(cores).max(1);
    let of = &of;
    thread::scope(|scope| {
        let parts: Vec<_> = items
            .chunks(share)
            .map(|part| scope.spawn(move || part.iter().map(of).collect::<Vec<R>>()))
            .collect();
        parts.into_iter().flat_map(|part| part.join().unwrap_or_else(|panic| resume_unwind(panic))).collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_comes_back_is_in_the_order_of_what_was_given() {
        for count in [0, 1, 2, 3, 101] {
            let numbers: Vec<usize> = (0..count).collect();
            let squares: Vec<usize> = numbers.iter().map(|k| k * k).collect();
            assert_eq!(each(&numbers, |k| k * k), squares);
        }
    }

    #[test]
    #[should_panic(expected = "number 3")]
    fn a_panic_of_one_is_one_of_all() {
        let _ = each(&[1, 2, 3], |k| assert_ne!(*k, 3, "number 3"));
    }
}
