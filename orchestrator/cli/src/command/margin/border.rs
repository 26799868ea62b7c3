//! The border between what holds and what does not, along one direction: by trying.
//!
//! Steps double until one does not hold, and then the gap is halved. So a stretch that does not hold between two that
//! do can be missed, as it can where somebody turns a knob.

/// Where it is, in steps away from the loop as it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Border {
    /// Not even the loop as it is holds.
    Nowhere,
    /// So many steps hold, and one more does not.
    After(usize),
    /// All steps that were tried hold, up to the most there are.
    Beyond(usize),
}

/// The border among `most` steps; `holds` says whether so many of them do.
///
/// # Errors
/// The first error of `holds`.
pub(super) fn border<E>(
    most: usize,
    mut holds: impl FnMut(usize) -> Result<bool, E>,
) -> Result<Border, E> {
    if !holds(0)? {
        return Ok(Border::Nowhere);
    }
    let (mut held, mut lost) = (0, None);
    while lost.is_none() && held < most {
        let next = (2 * held).clamp(1, most);
        if holds(next)? {
            held = next;
        } else {
            lost = Some(next);
        }
    }
    let Some(mut lost) = lost else {
        return Ok(Border::Beyond(held));
    };
    while lost - held > 1 {
        let middle = held + (lost - held) / 2;
        if holds(middle)? {
            held = middle;
        } else {
            lost = middle;
        }
    }
    Ok(Border::After(held))
}

#[cfg(test)]
mod tests {
    use std::convert::Infallible;

    use super::*;

    #[test]
    fn each_border_is_found_in_about_twice_its_digits() {
        for most in [1, 2, 7, 694] {
            for last in 0..=most {
                let mut runs = 0;
                let holds = |steps: usize| -> Result<bool, Infallible> {
                    assert!(steps <= most);
                    runs += 1;
                    Ok(steps <= last)
                };
                let Ok(found) = border(most, holds);
                let expected = if last == most {
                    Border::Beyond(most)
                } else {
                    Border::After(last)
                };
                assert_eq!(found, expected, "{last} of {most}");
                assert!(runs <= 3 + 2 * (last + 1).ilog2(), "{runs} for {last}");
            }
        }
        assert_eq!(border(9, |_| Ok::<_, ()>(false)), Ok(Border::Nowhere));
        assert_eq!(border(9, |_| Err(())), Err(()));
    }
}
