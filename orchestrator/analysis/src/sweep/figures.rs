//! The result of a run.

/// Declares the result of a run from the list of its figures, in the order of their columns.
macro_rules! figures {
    ($($(#[$meta:meta])* $figure:ident,)+) => {
        /// The figures of one run; `None` for a figure that does not exist.
        #[derive(Debug, Clone, Copy, PartialEq)]
        pub struct Figures {
            /// Whether the error dies out, see [`super::is_stable`].
            pub stable: bool,
            $($(#[$meta])* pub $figure: Option<f64>,)+
        }

        /// The columns of all figures, without `stable`.
        pub(crate) const COLUMNS: [&str; [$(stringify!($figure)),+].len()] =
            [$(stringify!($figure)),+];

        impl Figures {
            /// The figures in the order of `COLUMNS`.
            pub(crate) fn figures(&self) -> [Option<f64>; COLUMNS.len()] {
                [$(self.$figure),+]
            }

            /// The result with these figures, in the order of `COLUMNS`.
            pub(crate) fn of(stable: bool, figures: [Option<f64>; COLUMNS.len()]) -> Figures {
                let [$($figure),+] = figures;
                Figures { stable, $($figure),+ }
            }
        }
    };
}

figures! {
    /// The largest error in the last quarter over that in the second quarter, see
    /// [`super::growth()`].
    growth,
    /// Time until y stays within 2 % of the reference.
    settling_ms,
    /// Rise time, from 10 to 90 % of the reference.
    rise_ms,
    /// Overshoot beyond the reference, % of it.
    overshoot_pct,
    /// Integral of the absolute error, in units of y times s.
    iae_s,
    /// Integral of e² + rho u².
    cost_s,
    /// Share of the controller's deadlines at which it sent a message, %.
    sent_pct,
    /// Time from sending a message to its answer: the median of answered messages.
    rtt_median_ms,
    /// The 95 % quantile of the same.
    rtt_p95_ms,
    /// The maximum of the same.
    rtt_max_ms,
}
