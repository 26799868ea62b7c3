//! What a run came to.

/// Declares an outcome from the list of its figures, in the order of their columns.
macro_rules! figures {
    ($($(#[$meta:meta])* $figure:ident,)+) => {
        /// The figures of one run. What does not exist is `None`.
        #[derive(Debug, Clone, Copy, PartialEq)]
        pub struct Outcome {
            /// Whether the error dies out, see [`crate::is_stable`].
            pub stable: bool,
            $($(#[$meta])* pub $figure: Option<f64>,)+
        }

        /// Every figure but whether it is stable, by its column.
        pub(crate) const COLUMNS: [&str; [$(stringify!($figure)),+].len()] =
            [$(stringify!($figure)),+];

        impl Outcome {
            /// What it has in each of them.
            pub(crate) fn figures(&self) -> [Option<f64>; COLUMNS.len()] {
                [$(self.$figure),+]
            }

            /// From the same.
            pub(crate) fn of(stable: bool, figures: [Option<f64>; COLUMNS.len()]) -> Outcome {
                let [$($figure),+] = figures;
                Outcome { stable, $($figure),+ }
            }
        }
    };
}

figures! {
    /// The largest error of the last quarter over that of the second, see [`crate::growth()`].
    growth,
    /// Into 2 % of the reference for good.
    settling_ms,
    /// From 10 to 90 % of the reference.
    rise_ms,
    /// How far beyond the reference, % of it.
    overshoot_pct,
    /// Integral of the absolute error, in units of y times s.
    iae_s,
    /// Integral of e² + rho u².
    cost_s,
    /// Of the controller's deadlines, those at which it sent something, %.
    sent_pct,
    /// From a message's sending to its answer: the median of those that were answered.
    rtt_median_ms,
    /// The same, 95 % of them.
    rtt_p95_ms,
    /// The same, the longest.
    rtt_max_ms,
}
