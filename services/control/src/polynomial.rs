//! Real polynomials as slices of coefficients, highest power first: products, values, roots, and
//! for tests, Jury's.

use nalgebra::Complex;

/// The polynomial without its leading zeros; a zero polynomial is `[0.0]`.
pub(crate) fn trimmed(coefficients: &[f64]) -> &[f64] {
    let leading = coefficients.iter().take_while(|c| **c == 0.0).count();
    &coefficients[leading.min(coefficients.len().saturating_sub(1))..]
}

/// The value at `x`, by Horner's rule.
pub(crate) fn value(coefficients: &[f64], x: Complex<f64>) -> Complex<f64> {
    coefficients
        .iter()
        .fold(Complex::new(0.0, 0.0), |sum, c| sum * x + c)
}

/// The product of two polynomials.
pub(crate) fn product(a: &[f64], b: &[f64]) -> Vec<f64> {
    let mut out = vec![0.0; (a.len() + b.len()).saturating_sub(1)];
    for (i, x) in a.iter().enumerate() {
        for (j, y) in b.iter().enumerate() {
            out[i + j] += x * y;
        }
    }
    out
}

/// (s - root) (s - root) ..
pub(crate) fn from_roots(roots: &[f64]) -> Vec<f64> {
    let factors = roots.iter().map(|root| [1.0, -root]);
    factors.fold(vec![1.0], |all, factor| product(&all, &factor))
}

/// The sum of two polynomials, aligned at their lowest powers.
pub(crate) fn sum(a: &[f64], b: &[f64]) -> Vec<f64> {
    let (long, short) = if a.len() >= b.len() { (a, b) } else { (b, a) };
    let mut out = long.to_vec();
    let offset = long.len() - short.len();
    for (i, c) in short.iter().enumerate() {
        out[offset + i] += c;
    }
    out
}

/// Rounds of Aberth's iteration. Simple roots need about ten; only tight clusters need more.
const ROUNDS: usize = 400;
/// An iterate that moves by less than this part of itself has converged.
const CONVERGED: f64 = 4.0 * f64::EPSILON;

/// All roots. Zeros at the origin are split off exactly; the rest come from Aberth's simultaneous
/// iteration (O. Aberth, Math. Comp. 27, 1973), which, unlike shifted QR on a companion matrix, does
/// not stall on x^n - 1.
///
/// A root of multiplicity m is accurate to about the m-th root of the machine precision, as with any
/// method that starts from coefficients.
pub(crate) fn roots(coefficients: &[f64]) -> Vec<Complex<f64>> {
    let p = trimmed(coefficients);
    let at_origin = p.iter().rev().take_while(|c| **c == 0.0).count();
    if at_origin == p.len() {
        return Vec::new();
    }
    let p = &p[..p.len() - at_origin];
    let mut found = match p {
        [_] => Vec::new(),
        [a, b] => vec![Complex::new(-b / a, 0.0)],
        [a, b, c] => quadratic(*a, *b, *c).to_vec(),
        _ => aberth(p),
    };
    found.extend(std::iter::repeat_n(Complex::new(0.0, 0.0), at_origin));
    found
}

/// Both roots of a x² + b x + c without cancellation.
fn quadratic(a: f64, b: f64, c: f64) -> [Complex<f64>; 2] {
    let discriminant = b * b - 4.0 * a * c;
    if discriminant < 0.0 {
        let root = Complex::new(-b / (2.0 * a), (-discriminant).sqrt() / (2.0 * a));
        return [root, root.conj()];
    }
    let q = -0.5 * (b + b.signum() * discriminant.sqrt());
    [Complex::new(q / a, 0.0), Complex::new(c / q, 0.0)]
}

fn aberth(p: &[f64]) -> Vec<Complex<f64>> {
    let degree = p.len() - 1;
    let reversed: Vec<f64> = p.iter().rev().copied().collect();
    let mut z = first_guesses(p);
    for _ in 0..ROUNDS {
        let mut moved = false;
        for i in 0..degree {
            let newton = newton_step(p, &reversed, z[i]);
            let repulsion: Complex<f64> = (0..degree)
                .filter(|j| *j != i)
                .map(|j| (z[i] - z[j]).inv())
                .filter(|r| r.is_finite())
                .sum();
            let step = newton / (1.0 - newton * repulsion);
            if step.is_finite() {
                z[i] -= step;
                moved |= step.norm() > CONVERGED * z[i].norm();
            }
        }
        if !moved {
            break;
        }
    }
    // The imaginary part of a real root is only rounding.
    for root in &mut z {
        if root.im.abs() <= 16.0 * f64::EPSILON * root.re.abs() {
            root.im = 0.0;
        }
    }
    z
}

/// p/p' at x. Outside the unit circle it uses the reversed polynomial, whose powers cannot overflow.
fn newton_step(p: &[f64], reversed: &[f64], x: Complex<f64>) -> Complex<f64> {
    let degree = p.len() - 1;
    if x.norm() <= 1.0 {
        let (value, slope) = value_and_slope(p, x);
        return value / slope;
    }
    // With q(w) = w^n p(1/w) and w = 1/x: p/p' = x q / (n q - w q').
    let w = x.inv();
    let (value, slope) = value_and_slope(reversed, w);
    x * value / (value * degree as f64 - w * slope)
}

fn value_and_slope(p: &[f64], x: Complex<f64>) -> (Complex<f64>, Complex<f64>) {
    let zero = Complex::new(0.0, 0.0);
    p.iter().fold((zero, zero), |(value, slope), c| {
        (value * x + c, slope * x + value)
    })
}

/// Bini's choice: circles whose radii are the slopes of the Newton polygon (the upper hull of
/// ln|coefficient|), so that roots of very different size each start near their own magnitude.
fn first_guesses(p: &[f64]) -> Vec<Complex<f64>> {
    // An angle that is no rational fraction of a turn keeps guesses off every axis of symmetry.
    const OFFSET_RAD: f64 = 0.7;
    let degree = p.len() - 1;
    let log = |power: usize| p[degree - power].abs().ln();
    let mut hull: Vec<usize> = Vec::new();
    for power in (0..=degree).filter(|i| log(*i).is_finite()) {
        while let [.., a, b] = hull[..] {
            let rise = |i: usize, j: usize| (log(j) - log(i)) / (j - i) as f64;
            if rise(a, b) > rise(b, power) {
                break;
            }
            hull.pop();
        }
        hull.push(power);
    }
    let mut guesses = Vec::with_capacity(degree);
    for pair in hull.windows(2) {
        let count = pair[1] - pair[0];
        let radius = ((log(pair[0]) - log(pair[1])) / count as f64).exp();
        for i in 0..count {
            let turn =
                std::f64::consts::TAU * (i as f64 / count as f64 + pair[0] as f64 / degree as f64);
            guesses.push(Complex::from_polar(radius, turn + OFFSET_RAD));
        }
    }
    guesses
}

/// Whether every root lies strictly inside the unit circle: Jury's test as the step-down recursion,
/// whose reflection coefficients must all be smaller than one in magnitude (E. I. Jury, 1964).
#[cfg(test)]
pub(crate) fn is_schur_stable(coefficients: &[f64]) -> bool {
    let mut p = trimmed(coefficients).to_vec();
    while p.len() > 1 {
        let reflection = p[p.len() - 1] / p[0];
        if reflection.is_nan() || reflection.abs() >= 1.0 {
            return false;
        }
        let scale = 1.0 - reflection * reflection;
        let last = p.len() - 1;
        p = (0..last)
            .map(|i| (p[i] - reflection * p[last - i]) / (p[0] * scale))
            .collect();
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    fn assert_roots(coefficients: &[f64], expected: &[(f64, f64)], tolerance: f64) {
        let mut found = roots(coefficients);
        assert_eq!(found.len(), expected.len());
        for (re, im) in expected {
            let target = Complex::new(*re, *im);
            let nearest = (0..found.len())
                .min_by(|a, b| {
                    (found[*a] - target)
                        .norm()
                        .total_cmp(&(found[*b] - target).norm())
                })
                .expect("as many roots as expected");
            let distance = (found.swap_remove(nearest) - target).norm();
            assert!(
                distance <= tolerance * target.norm().max(1e-3),
                "{target} missed by {distance}"
            );
        }
    }

    #[test]
    fn roots_of_unity_are_found_where_plain_shifted_qr_stalls() {
        assert_roots(
            &[1.0, 0.0, 0.0, 0.0, -1.0],
            &[(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)],
            1e-14,
        );
    }

    #[test]
    fn roots_nine_decades_apart_keep_their_relative_precision() {
        // (x + 1e-3)(x + 1)(x + 1e6): each root starts from its own edge of the Newton polygon.
        let p = product(&product(&[1.0, 1e-3], &[1.0, 1.0]), &[1.0, 1e6]);
        assert_roots(&p, &[(-1e-3, 0.0), (-1.0, 0.0), (-1e6, 0.0)], 1e-12);
    }

    #[test]
    fn a_triple_root_is_found_to_the_cube_root_of_the_precision() {
        // eps^(1/3) = 6e-6.
        let p = product(&product(&[1.0, 1.0], &[1.0, 1.0]), &[1.0, 1.0]);
        assert_roots(&p, &[(-1.0, 0.0); 3], 1e-4);
    }

    #[test]
    fn roots_at_the_origin_are_exact_and_constants_have_none() {
        assert_eq!(roots(&[2.0, 0.0, 0.0]), vec![Complex::new(0.0, 0.0); 2]);
        assert!(roots(&[3.0]).is_empty());
        assert!(roots(&[0.0]).is_empty());
    }

    #[test]
    fn jurys_test_agrees_with_the_roots_on_both_sides_of_the_circle() {
        assert!(is_schur_stable(&product(&[1.0, -0.999], &[1.0, 0.3, 0.9])));
        assert!(!is_schur_stable(&product(&[1.0, -1.001], &[1.0, 0.3, 0.9])));
        assert!(!is_schur_stable(&[1.0, -1.0]));
        assert!(is_schur_stable(&[5.0]));
    }
}
