//! Pseudo-velocity shock spectra and doses of a motion whose acceleration is piecewise cubic.
//!
//! An oscillator of natural circular frequency `w` and damping ratio `zeta = 1 / (2 Q)` stands on the moving point. Its elongation `z` obeys
//!
//! ```text
//! z'' + 2 zeta w z' + w^2 z = -a(t)
//! ```
//!
//! and its pseudo-velocity is `w z`. With `lambda = w (-zeta + i sqrt(1 - zeta^2))` and `u = z' - conj(lambda) z` this is `u' = lambda u - a`.
//! For a cubic `a = sum_i c_i s^i`, `s` from 0 to 1 over a length `tau`,
//!
//! ```text
//! u(tau) = exp(x) u(0) - tau sum_i i! c_i phi_{i+1}(x),    x = lambda tau
//! phi_1(x) = (exp(x) - 1) / x,    phi_{k+1}(x) = (phi_k(x) - 1/k!) / x
//! ```
//!
//! holds exactly. Where the motion has a residual part `delta` without mass besides, whose rates jump, `q = u + delta' + lambda delta` obeys
//! `q' = lambda q - a - lambda^2 delta`: only `delta` itself is needed. The frequencies are a third of an octave apart. The functions of an octave are computed from those of the octave below,
//! and those of the lowest octave from a series.

use std::f64::consts::TAU;

use pulp::Arch;

/// Number of oscillators: third octaves over six octaves and two thirds, 98 Hz to 10 kHz.
pub const BAND: usize = 21;
/// Oscillators per octave.
const PER_OCTAVE: usize = 3;
/// Highest natural frequency of the band in Hz.
pub const HIGHEST_HZ: f64 = 10_000.0;
/// Angle `w tau` up to which the extremes of an oscillation are read off its ends. The quintic through both ends then errs by 1e-6.
const LARGEST_ANGLE: f64 = 0.6;
/// Terms of the series of `phi_4` for angles up to [`LARGEST_ANGLE`]: an error of 2e-12.
const TERMS: usize = 10;
/// Steps of Newton's method to an extreme.
const REFINEMENTS: usize = 2;

/// Numbers of all oscillators: real and imaginary parts.
#[derive(Debug, Clone, Copy)]
struct Complex {
    re: [f64; BAND],
    im: [f64; BAND],
}

impl Complex {
    const ZERO: Self = Self { re: [0.0; BAND], im: [0.0; BAND] };

    #[inline]
    fn at(&self, k: usize) -> [f64; 2] {
        [self.re[k], self.im[k]]
    }

    fn set(&mut self, k: usize, [re, im]: [f64; 2]) {
        (self.re[k], self.im[k]) = (re, im);
    }
}

fn times([a, b]: [f64; 2], [c, d]: [f64; 2]) -> [f64; 2] {
    [a * c - b * d, a * d + b * c]
}

fn sum(values: &[f64]) -> f64 {
    values.iter().sum()
}

/// A piece of a motion, its coefficients by powers of the fraction of the piece.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Piece {
    /// Acceleration in m/s2, the residual motion left out.
    pub acceleration_m_s2: [f64; 4],
    /// Residual motion `delta` in m. It has no mass: its rate may jump between pieces.
    pub residual_m: [f64; 4],
}

impl Piece {
    /// The part from fraction `from` on that is `share` long.
    #[must_use]
    pub fn part(&self, from: f64, share: f64) -> Self {
        Self {
            acceleration_m_s2: part_of_cubic(self.acceleration_m_s2, from, share),
            residual_m: part_of_cubic(self.residual_m, from, share),
        }
    }
}

/// Coefficients of the part of a cubic from fraction `from` on that is `share` long, by powers of the fraction of that part.
fn part_of_cubic([c0, c1, c2, c3]: [f64; 4], from: f64, share: f64) -> [f64; 4] {
    [
        c0 + from * (c1 + from * (c2 + from * c3)),
        share * (c1 + from * (2.0 * c2 + 3.0 * from * c3)),
        share * share * (c2 + 3.0 * from * c3),
        share * share * share * c3,
    ]
}

/// The oscillators of a band.
#[derive(Debug, Clone)]
pub struct Oscillators {
    omega: [f64; BAND],
    /// Periods over 2 pi, s.
    period: [f64; BAND],
    zeta: f64,
    lambda: Complex,
    lambda_squared: Complex,
    /// Pseudo-velocity by the imaginary part of `u`.
    scale: f64,
}

impl Oscillators {
    /// Oscillators of one quality factor, from a lowest natural frequency on.
    pub fn new(lowest_hz: f64, quality: f64) -> Self {
        let zeta = 0.5 / quality;
        let root = (1.0 - zeta * zeta).sqrt();
        let omega: [f64; BAND] = std::array::from_fn(|k| TAU * lowest_hz * libm::exp2(k as f64 / PER_OCTAVE as f64));
        let lambda = Complex { re: omega.map(|omega| -zeta * omega), im: omega.map(|omega| root * omega) };
        let mut lambda_squared = Complex::ZERO;
        (0..BAND).for_each(|k| lambda_squared.set(k, times(lambda.at(k), lambda.at(k))));
        Self { omega, period: omega.map(f64::recip), zeta, lambda, lambda_squared, scale: 1.0 / root }
    }

    /// Both ends of a part of the oscillation of oscillator `k` with `q` there. The part lasts `tau_s`.
    #[inline]
    fn ends(&self, k: usize, q: [[f64; 2]; 2], (piece, tau_s): (&Piece, f64)) -> [End; 2] {
        let [_, b, c, d] = piece.residual_m;
        let per_s = 1.0 / tau_s;
        let residual = [
            [piece.residual_m[0], b * per_s, 2.0 * c * per_s * per_s],
            [sum(&piece.residual_m), (b + 2.0 * c + 3.0 * d) * per_s, (2.0 * c + 6.0 * d) * per_s * per_s],
        ];
        let accelerations = [piece.acceleration_m_s2[0], sum(&piece.acceleration_m_s2)];
        std::array::from_fn(|end| {
            let ([re, im], [delta, rate, bend]) = (q[end], residual[end]);
            let turn = self.omega[k] * delta;
            let value = self.scale * im - turn;
            let velocity = re - rate + self.zeta * (turn - value);
            End { value, velocity, drive: (accelerations[end] + bend) * self.period[k] }
        })
    }

    /// Drive of oscillator `k`: `c + lambda^2 d` with the coefficients of acceleration and residual motion.
    #[inline]
    fn drive(&self, k: usize, piece: &Piece) -> [[f64; 2]; 4] {
        let [re, im] = self.lambda_squared.at(k);
        std::array::from_fn(|power| {
            let residual = piece.residual_m[power];
            [piece.acceleration_m_s2[power] + re * residual, im * residual]
        })
    }

    /// Natural frequencies in Hz.
    pub fn frequencies_hz(&self) -> [f64; BAND] {
        self.omega.map(|omega| omega / TAU)
    }

    /// Longest piece in s that [`Propagator::new`] takes.
    pub fn longest_s(&self) -> f64 {
        LARGEST_ANGLE / self.omega[PER_OCTAVE - 1]
    }
}

/// Lowest natural frequency in Hz of the band that ends at [`HIGHEST_HZ`].
pub fn lowest_hz() -> f64 {
    HIGHEST_HZ * libm::exp2(-((BAND - 1) as f64) / PER_OCTAVE as f64)
}

/// Factors that take all oscillators through one piece of a motion. They depend on its length only.
#[derive(Debug, Clone)]
pub struct Propagator {
    tau_s: f64,
    exp: Complex,
    /// `i! phi_{i+1}`.
    phi: [Complex; 4],
}

impl Propagator {
    /// For a piece of a length in s, at most [`Oscillators::longest_s`].
    pub fn new(of: &Oscillators, tau_s: f64) -> Self {
        let mut own = Self { tau_s, exp: Complex::ZERO, phi: [Complex::ZERO; 4] };
        for k in 0..PER_OCTAVE {
            own.set(k, lowest_octave(of.lambda.at(k).map(|part| part * tau_s)));
        }
        for k in PER_OCTAVE..BAND {
            own.set(k, own.doubled(k - PER_OCTAVE));
        }
        for (phi, factorial) in own.phi.iter_mut().zip([1.0, 1.0, 2.0, 6.0]) {
            phi.re.iter_mut().chain(&mut phi.im).for_each(|part| *part *= factorial);
        }
        own
    }

    fn set(&mut self, k: usize, [exp, phi @ ..]: [[f64; 2]; 5]) {
        self.exp.set(k, exp);
        self.phi.iter_mut().zip(phi).for_each(|(to, from)| to.set(k, from));
    }

    /// Doubles the argument x of oscillator `k`: `exp(2 x) = exp(x)^2`, `phi_k(2 x) = 2^-k (exp(x) phi_k(x) + sum_j phi_j(x) / (k - j)!)`.
    fn doubled(&self, k: usize) -> [[f64; 2]; 5] {
        let exp = self.exp.at(k);
        let phi = self.phi.each_ref().map(|phi| phi.at(k));
        let sum = |part: usize| {
            let [one, two, three, four] = phi.map(|phi| phi[part]);
            [one, two + one, three + two + 0.5 * one, four + three + 0.5 * two + one / 6.0]
        };
        let (re, im) = (sum(0), sum(1));
        let one = |j: usize, half: f64| {
            let [a, b] = times(exp, phi[j]);
            [half * (a + re[j]), half * (b + im[j])]
        };
        [times(exp, exp), one(0, 0.5), one(1, 0.25), one(2, 0.125), one(3, 0.0625)]
    }

    /// `q` of all oscillations at the end of the piece from that at its start.
    #[inline(always)]
    fn apply_all(&self, u: &mut Complex, acceleration: &[f64; 4]) {
        let weights = acceleration.map(|c| self.tau_s * c);
        for k in 0..BAND {
            let (re, im) = (u.re[k], u.im[k]);
            let (mut sum_re, mut sum_im) = (0.0, 0.0);
            for (phi, weight) in self.phi.iter().zip(weights) {
                sum_re += weight * phi.re[k];
                sum_im += weight * phi.im[k];
            }
            u.re[k] = self.exp.re[k] * re - self.exp.im[k] * im - sum_re;
            u.im[k] = self.exp.re[k] * im + self.exp.im[k] * re - sum_im;
        }
    }

    /// Adds to `q` of all oscillations at the end of the piece what the residual motion causes.
    #[inline(always)]
    fn add_residual(&self, of: &Oscillators, q: &mut Complex, residual_m: &[f64; 4]) {
        let weights = residual_m.map(|d| self.tau_s * d);
        for k in 0..BAND {
            let (mut sum_re, mut sum_im) = (0.0, 0.0);
            for (phi, weight) in self.phi.iter().zip(weights) {
                sum_re += weight * phi.re[k];
                sum_im += weight * phi.im[k];
            }
            let (re, im) = (of.lambda_squared.re[k], of.lambda_squared.im[k]);
            q.re[k] -= re * sum_re - im * sum_im;
            q.im[k] -= re * sum_im + im * sum_re;
        }
    }

    /// `q` of one oscillation at the end of a piece that lasts `tau_s` from that at its start.
    fn apply(&self, k: usize, q: [f64; 2], (drive, tau_s): (&[[f64; 2]; 4], f64)) -> [f64; 2] {
        let [mut re, mut im] = times(self.exp.at(k), q);
        for (phi, c) in self.phi.iter().zip(drive) {
            let [c_re, c_im] = times(*c, [phi.re[k], phi.im[k]]);
            re -= tau_s * c_re;
            im -= tau_s * c_im;
        }
        [re, im]
    }
}

/// `exp` and `phi_1` to `phi_4` of a small number: the last by its series, the others by their recurrence.
fn lowest_octave(x: [f64; 2]) -> [[f64; 2]; 5] {
    let mut factorials = [1.0; TERMS + 4];
    for n in 1..TERMS + 4 {
        factorials[n] = factorials[n - 1] * n as f64;
    }
    let next = |phi: [f64; 2], constant: f64| {
        let [re, im] = times(x, phi);
        [re + constant, im]
    };
    let four = (4..TERMS + 4).rev().fold([0.0; 2], |sum, n| next(sum, 1.0 / factorials[n]));
    let three = next(four, 1.0 / 6.0);
    let two = next(three, 0.5);
    let one = next(two, 1.0);
    [next(one, 1.0), one, two, three, four]
}

/// Weight of a cycle: `(largest pseudo-velocity / reference)^exponent`, above a threshold.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Damage {
    /// Pseudo-velocity in m/s of which a cycle counts 1.
    pub reference_m_s: f64,
    /// Exponent.
    pub exponent: f64,
    /// Pseudo-velocity in m/s below which a cycle counts nothing.
    pub threshold_m_s: f64,
}

/// Oscillators on a motion.
#[derive(Debug, Clone)]
pub struct ShockMotion {
    q: Complex,
    /// `q` at the start of the present piece.
    before: Complex,
    /// Bound of the size of `u` in the present piece.
    bound: [f64; BAND],
    piece: Piece,
}

impl ShockMotion {
    /// Oscillators at rest.
    pub const AT_REST: Self = Self {
        q: Complex::ZERO,
        before: Complex::ZERO,
        bound: [0.0; BAND],
        piece: Piece { acceleration_m_s2: [0.0; 4], residual_m: [0.0; 4] },
    };

    /// Follows a piece.
    pub fn advance(&mut self, of: &Oscillators, propagator: &Propagator, piece: Piece) {
        let size = |coefficients: &[f64; 4]| coefficients.iter().map(|c| c.abs()).sum::<f64>();
        let gain = propagator.tau_s * size(&piece.acceleration_m_s2);
        let residual = size(&piece.residual_m);
        (self.before, self.piece) = (self.q, piece);
        let Self { q, bound, .. } = self;
        Arch::new().dispatch(|| {
            for (bound, (re, im)) in bound.iter_mut().zip(q.re.iter().zip(&q.im)) {
                *bound = gain + (re * re + im * im).sqrt();
            }
            propagator.apply_all(q, &piece.acceleration_m_s2);
            if residual > 0.0 {
                for (bound, omega) in bound.iter_mut().zip(&of.omega) {
                    *bound += omega * residual * (1.0 + omega * propagator.tau_s);
                }
                propagator.add_residual(of, q, &piece.residual_m);
            }
        });
    }
}

/// Largest pseudo-velocities and doses of the oscillators on one point.
#[derive(Debug, Clone)]
pub struct ShockResponse {
    damage: Option<Damage>,
    /// Largest pseudo-velocities of the present cycles, m/s. A cycle reaches from one passage of zero upwards to the next.
    cycle: [f64; BAND],
    /// Cycles that count so far, one bit each.
    cycles: u32,
    dose: [f64; BAND],
    run: [f64; BAND],
    window: [f64; BAND],
    /// Pseudo-velocities up to which nothing needs to be looked at, m/s.
    level: [f64; BAND],
    watch: Watch,
    /// Whether a level has risen in the present piece.
    rises: bool,
}

/// Part of the present window that is recorded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Watch {
    /// Nothing: no window is open.
    Nothing,
    /// The largest pseudo-velocity over the band.
    Largest,
    /// The whole spectrum.
    Spectrum,
}

impl ShockResponse {
    /// Of oscillators at rest.
    pub fn new(damage: Option<Damage>) -> Self {
        Self {
            damage,
            cycle: [0.0; BAND],
            cycles: 0,
            dose: [0.0; BAND],
            run: [0.0; BAND],
            window: [0.0; BAND],
            level: [0.0; BAND],
            watch: Watch::Nothing,
            rises: false,
        }
    }

    /// Ends the present window and opens one again; returns the pseudo-velocities of the old one in m/s.
    pub fn open(&mut self, watch: Watch) -> [f64; BAND] {
        self.watch = watch;
        let old = std::mem::replace(&mut self.window, [0.0; BAND]);
        self.set_levels();
        old
    }

    /// Changes the computed quantities of the present window from now on.
    pub fn watch(&mut self, watch: Watch) {
        self.watch = watch;
        self.set_levels();
    }

    /// Largest pseudo-velocities since the start, m/s.
    pub fn spectrum_m_s(&self) -> &[f64; BAND] {
        &self.run
    }

    /// Doses so far, the present cycles included.
    pub fn doses(&self) -> [f64; BAND] {
        std::array::from_fn(|k| self.dose[k] + self.counts(self.cycle[k]))
    }

    /// Whether one of the doses, the present cycles left out, has reached this one.
    pub fn has_dose(&self, dose: f64) -> bool {
        self.dose.iter().any(|own| *own >= dose)
    }

    /// Contribution of a cycle with this largest pseudo-velocity.
    fn counts(&self, largest_m_s: f64) -> f64 {
        match self.damage {
            Some(Damage { reference_m_s, exponent, threshold_m_s }) if largest_m_s >= threshold_m_s => {
                libm::pow(largest_m_s / reference_m_s, exponent)
            }
            _ => 0.0,
        }
    }

    fn set_levels(&mut self) {
        let threshold = self.damage.map_or(f64::INFINITY, |damage| damage.threshold_m_s);
        let largest = self.window.iter().fold(0.0_f64, |largest, one| largest.max(*one));
        for k in 0..BAND {
            let window = match self.watch {
                Watch::Nothing => f64::INFINITY,
                Watch::Largest => largest,
                Watch::Spectrum => self.window[k],
            };
            self.level[k] = self.run[k].min(threshold).min(window);
        }
    }

    /// Follows a piece of the motion of a point that is the sum of some motions, each with its share.
    pub fn follow(&mut self, of: &Oscillators, propagator: &Propagator, (motions, shares): (&[ShockMotion], &[f64])) {
        let mut bound = [0.0; BAND];
        for (motion, share) in motions.iter().zip(shares).filter(|(_, share)| **share != 0.0) {
            let share = share.abs() * of.scale;
            bound.iter_mut().zip(&motion.bound).for_each(|(sum, own)| *sum += share * own);
        }
        let looked_at = (0..BAND).fold(0_u32, |bits, k| bits | u32::from(bound[k] > self.level[k]) << k);
        if looked_at == 0 && self.cycles == 0 {
            return;
        }
        let sum = |of: &dyn Fn(&ShockMotion) -> f64| {
            motions.iter().zip(shares).map(|(motion, share)| share * of(motion)).sum::<f64>()
        };
        let piece = Piece {
            acceleration_m_s2: std::array::from_fn(|power| sum(&|motion| motion.piece.acceleration_m_s2[power])),
            residual_m: std::array::from_fn(|power| sum(&|motion| motion.piece.residual_m[power])),
        };
        for k in 0..BAND {
            if looked_at >> k & 1 != 0 {
                let ends = [
                    [sum(&|motion| motion.before.re[k]), sum(&|motion| motion.before.im[k])],
                    [sum(&|motion| motion.q.re[k]), sum(&|motion| motion.q.im[k])],
                ];
                self.look(of, propagator, &piece, (k, ends));
            } else if self.cycles >> k & 1 != 0 {
                self.close(k);
            }
        }
        if std::mem::take(&mut self.rises) {
            self.set_levels();
        }
    }

    /// Ends the present cycle of an oscillator.
    fn close(&mut self, k: usize) {
        self.dose[k] += self.counts(self.cycle[k]);
        self.cycle[k] = 0.0;
        self.cycles &= !(1 << k);
    }

    /// Follows one oscillation through a piece, in as many parts as it needs: the propagator of an octave below is that of half a piece.
    fn look(
        &mut self,
        of: &Oscillators,
        propagator: &Propagator,
        piece: &Piece,
        (k, [mut q, last]): (usize, [[f64; 2]; 2]),
    ) {
        let (mut halvings, mut angle) = (0, of.omega[k] * propagator.tau_s);
        while angle > LARGEST_ANGLE && PER_OCTAVE * (halvings + 1) <= k {
            halvings += 1;
            angle *= 0.5;
        }
        if halvings == 0 {
            return self.part(of, (k, angle), &of.ends(k, [q, last], (piece, propagator.tau_s)));
        }
        let parts = 1_u32 << halvings;
        let share = 1.0 / f64::from(parts);
        let tau_s = share * propagator.tau_s;
        for part in 0..parts {
            let own = piece.part(f64::from(part) * share, share);
            let end = propagator.apply(k - PER_OCTAVE * halvings, q, (&of.drive(k, &own), tau_s));
            self.part(of, (k, angle), &of.ends(k, [q, end], (&own, tau_s)));
            q = end;
        }
    }

    /// Looks at one part of an oscillation, shorter than a tenth of a period.
    #[inline]
    fn part(&mut self, of: &Oscillators, (k, angle): (usize, f64), [start, end]: &[End; 2]) {
        let turns = start.velocity * end.velocity < 0.0;
        let inner = if turns { extreme(of.zeta, angle, [start, end]).abs() } else { 0.0 };
        let largest = inner.max(end.value.abs());
        if largest > self.run[k] || self.watch != Watch::Nothing && largest > self.window[k] {
            self.run[k] = self.run[k].max(largest);
            if self.watch != Watch::Nothing {
                self.window[k] = self.window[k].max(largest);
            }
            self.rises = true;
        }
        if self.damage.is_some() {
            self.cycle[k] = self.cycle[k].max(largest);
            self.cycles |= 1 << k;
        }
        if start.value < 0.0 && end.value >= 0.0 {
            self.close(k);
        }
    }
}

/// An end of a part of an oscillation: pseudo-velocity, velocity of the oscillator, and the acceleration that drives it over its natural
/// circular frequency, all in m/s.
#[derive(Debug, Clone, Copy)]
struct End {
    value: f64,
    velocity: f64,
    drive: f64,
}

/// Extreme between two ends with velocities of different sign, `angle` apart.
fn extreme(zeta: f64, angle: f64, [start, end]: [&End; 2]) -> f64 {
    // Derivatives of the pseudo-velocity by the fraction of the part.
    let slope = |of: &End| angle * of.velocity;
    let curvature = |of: &End| -angle * angle * (of.drive + 2.0 * zeta * of.velocity + of.value);
    let ([slope_0, slope_1], [bend_0, bend_1]) = ([slope(start), slope(end)], [curvature(start), curvature(end)]);
    // Taylor coefficients at the start of the quintic through both ends.
    let rise = end.value - start.value - slope_0 - 0.5 * bend_0;
    let bend = slope_1 - slope_0 - bend_0;
    let twist = bend_1 - bend_0;
    let three = 10.0 * rise - 4.0 * bend + 0.5 * twist;
    let four = -15.0 * rise + 7.0 * bend - twist;
    let five = 6.0 * rise - 3.0 * bend + 0.5 * twist;
    let mut at = slope_0 / (slope_0 - slope_1);
    for _ in 0..REFINEMENTS {
        let slope = slope_0 + at * (bend_0 + at * (3.0 * three + at * (4.0 * four + at * 5.0 * five)));
        let curvature = bend_0 + at * (6.0 * three + at * (12.0 * four + at * 20.0 * five));
        at = if curvature == 0.0 { at } else { (at - slope / curvature).clamp(0.0, 1.0) };
    }
    start.value + at * (slope_0 + at * (0.5 * bend_0 + at * (three + at * (four + at * five))))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A point with a motion of its own.
    struct Point {
        motion: ShockMotion,
        response: ShockResponse,
    }

    impl Point {
        fn new(damage: Option<Damage>) -> Self {
            Self { motion: ShockMotion::AT_REST, response: ShockResponse::new(damage) }
        }

        fn follow(&mut self, of: &Oscillators, propagator: &Propagator, acceleration: [f64; 4]) {
            self.advance(of, propagator, Piece { acceleration_m_s2: acceleration, residual_m: [0.0; 4] });
        }

        fn advance(&mut self, of: &Oscillators, propagator: &Propagator, piece: Piece) {
            self.motion.advance(of, propagator, piece);
            self.response.follow(of, propagator, (std::slice::from_ref(&self.motion), &[1.0]));
        }
    }

    /// Follows an acceleration from 0 to `end_s` in cubic pieces through four samples each.
    fn followed(of: &Oscillators, damage: Option<Damage>, end_s: f64, a: impl Fn(f64) -> f64) -> Point {
        let mut point = Point::new(damage);
        let pieces = (end_s / of.longest_s()).ceil().max(40.0);
        let tau = end_s / pieces;
        let propagator = Propagator::new(of, tau);
        for piece in 0..pieces as usize {
            let [p, q, r, s] = [0.0, 1.0, 2.0, 3.0].map(|third| a((piece as f64 + third / 3.0) * tau));
            let c = [
                p,
                0.5 * (-11.0 * p + 18.0 * q - 9.0 * r + 2.0 * s),
                0.5 * (18.0 * p - 45.0 * q + 36.0 * r - 9.0 * s),
                0.5 * (-9.0 * p + 27.0 * q - 27.0 * r + 9.0 * s),
            ];
            point.follow(of, &propagator, c);
        }
        point
    }

    /// Lets the oscillators ring for a time without motion.
    fn ring(point: &mut Point, of: &Oscillators, duration_s: f64) {
        let pieces = (duration_s / of.longest_s()).ceil();
        let propagator = Propagator::new(of, duration_s / pieces);
        (0..pieces as usize).for_each(|_| point.follow(of, &propagator, [0.0; 4]));
    }

    /// A half-sine of 1 ms and 1000 m/s2 leaves undamped oscillators with the amplitude `2 A r / |1 - r^2| |cos(w T / 2)|`, `r = pi / (w T)`.
    #[test]
    fn analytic_residual_spectrum_of_a_half_sine() {
        for (lowest_hz, expected) in [(100.0, [(0, 396.27)].as_slice()), (500.0, &[(0, 1570.80), (3, 1333.33)])] {
            let of = Oscillators::new(lowest_hz, 1e12);
            let mut point = followed(&of, None, 1e-3, |t| 1000.0 * (std::f64::consts::PI * t / 1e-3).sin());
            point.response.open(Watch::Spectrum);
            ring(&mut point, &of, 0.02);
            let spectrum = point.response.open(Watch::Nothing);
            for (k, amplitude) in expected {
                let found = of.omega[*k] * spectrum[*k];
                assert!((found / amplitude - 1.0).abs() < 1e-5, "{found} {amplitude}");
            }
            for (k, pseudo) in spectrum.iter().enumerate() {
                let angle = of.omega[k] * 1e-3;
                let r = std::f64::consts::PI / angle;
                let exact = 2.0 * 1000.0 * r / (1.0 - r * r).abs() * (0.5 * angle).cos().abs() / of.omega[k];
                // At the resonance itself the formula is 0 / 0.
                assert!((pseudo - exact).abs() < 2e-6 || (r - 1.0).abs() < 1e-3, "{k}: {pseudo} {exact}");
            }
        }
    }

    /// A ring-down from 3000 m/s over a threshold of 300, damping ratio 0.02, exponent 5: 19 cycles count, 2.143246 (A / reference)^5.
    #[test]
    fn analytic_dose_of_a_ring_down() {
        let of = Oscillators::new(100.0, 25.0);
        for (factor, threshold) in [(1.0, 300.0), (2.0, 600.0)] {
            let damage = Damage { reference_m_s: 100.0, exponent: 5.0, threshold_m_s: threshold };
            let mut point = Point::new(Some(damage));
            // At rest at a largest elongation.
            let start = 3000.0 * factor;
            (0..BAND).for_each(|k| point.motion.q.set(k, [of.zeta * start, start / of.scale]));
            (point.response.cycle, point.response.cycles) = ([start; BAND], u32::MAX >> (32 - BAND));
            ring(&mut point, &of, 0.4);
            // Largest values of one sign fall by this factor from one to the next.
            let ratio = (-std::f64::consts::TAU * of.zeta * of.scale).exp();
            let cycles = (0.1_f64.ln() / ratio.ln()).floor() as i32 + 1;
            let exact = (0..cycles).map(|n| ratio.powi(5 * n)).sum::<f64>();
            assert_eq!(cycles, 19);
            assert!((exact - 2.143_246).abs() < 2e-4, "{exact}");
            for (k, dose) in point.response.doses().into_iter().enumerate() {
                let expected = exact * (30.0 * factor).powi(5);
                assert!((dose / expected - 1.0).abs() < 2e-5, "{k}: {dose} {expected}");
            }
        }
    }

    /// Long and short pieces, cut anywhere, give the same spectra: pieces are exact, extremes between their ends are found.
    #[test]
    fn pieces_of_any_length_show_the_same() {
        let of = Oscillators::new(lowest_hz(), 10.0);
        let c = [300.0, -2000.0, 5000.0, -3200.0];
        let whole_s = of.longest_s();
        let mut found = Vec::new();
        for pieces in [1_usize, 2, 7, 64] {
            let mut point = Point::new(Some(Damage { reference_m_s: 1.0, exponent: 4.0, threshold_m_s: 0.0 }));
            point.response.open(Watch::Spectrum);
            let share = 1.0 / pieces as f64;
            let propagator = Propagator::new(&of, whole_s * share);
            for piece in 0..pieces {
                let at = piece as f64 * share;
                let own = part_of_cubic(c, at, share);
                point.follow(&of, &propagator, own);
            }
            ring(&mut point, &of, 0.05);
            found.push((*point.response.spectrum_m_s(), point.response.doses()));
        }
        let (spectrum, doses) = found[3];
        assert!(spectrum.iter().all(|one| *one > 1e-3));
        for (other, other_doses) in &found[..3] {
            for k in 0..BAND {
                assert!((other[k] / spectrum[k] - 1.0).abs() < 2e-6, "{k}: {} {}", other[k], spectrum[k]);
                assert!((other_doses[k] / doses[k] - 1.0).abs() < 1e-5, "{k}: {} {}", other_doses[k], doses[k]);
            }
        }
    }

    /// A residual motion shows the same as an acceleration that is its second rate, after the jumps of its rate have been added.
    #[test]
    fn residual_motion_equals_its_acceleration() {
        let of = Oscillators::new(lowest_hz(), 10.0);
        // Displacement 1e-5 (s^2 (3 - 2 s)) over the piece: at rest at both ends.
        let (rise_m, whole_s) = (1e-5, of.longest_s());
        let bend = rise_m / (whole_s * whole_s);
        let accelerated = Piece { acceleration_m_s2: [6.0 * bend, -12.0 * bend, 0.0, 0.0], residual_m: [0.0; 4] };
        let moved = Piece { acceleration_m_s2: [0.0; 4], residual_m: [0.0, 0.0, 3.0 * rise_m, -2.0 * rise_m] };
        let held = Piece { acceleration_m_s2: [0.0; 4], residual_m: [rise_m, 0.0, 0.0, 0.0] };
        let spectra = [(accelerated, Piece::default()), (moved, held)].map(|(first, then)| {
            let mut point = Point::new(None);
            let pieces = 7;
            let share = 1.0 / f64::from(pieces);
            let propagator = Propagator::new(&of, whole_s * share);
            for piece in 0..pieces {
                point.advance(&of, &propagator, first.part(f64::from(piece) * share, share));
            }
            let propagator = Propagator::new(&of, of.longest_s());
            (0..100).for_each(|_| point.advance(&of, &propagator, then));
            *point.response.spectrum_m_s()
        });
        for k in 0..BAND {
            assert!(spectra[0][k] > 1e-3 && (spectra[1][k] / spectra[0][k] - 1.0).abs() < 1e-6, "{k}: {spectra:?}");
        }
    }
}
