//! Times of one thread, in turns, so that a machine that slows down slows all that is compared.

use cpu_time::ThreadTime;

/// CPU time in s that a turn of a short case takes at least: as long as others', so that it does not fall into a moment in
/// which the machine happens to be fast or slow.
const TURN_S: f64 = 1.0;
/// CPU time in s above which a case is run fewer times: (limit, runs).
const FEWER: [(f64, usize); 2] = [(2.0, 3), (20.0, 1)];

/// What a case gave the last time, and the median CPU time in s of its turns.
pub struct Timed<T> {
    /// What it gave.
    pub value: T,
    /// Median.
    pub cpu_s: f64,
}

/// Gives every case `repeats` turns, long ones fewer; a turn's time is the mean of its runs.
pub fn interleaved<C, T>(repeats: usize, cases: &[C], mut run: impl FnMut(&C) -> T) -> Vec<Timed<T>> {
    let mut times: Vec<Vec<f64>> = cases.iter().map(|_| Vec::with_capacity(repeats)).collect();
    let mut values: Vec<Option<T>> = cases.iter().map(|_| None).collect();
    for _ in 0..repeats {
        for ((case, times), value) in cases.iter().zip(&mut times).zip(&mut values) {
            let first = times.first().copied().unwrap_or(0.0);
            let enough = FEWER.iter().filter(|(limit, _)| first > *limit).map(|(_, runs)| *runs).min();
            if times.len() >= enough.unwrap_or(repeats) {
                continue;
            }
            let begin = ThreadTime::now();
            let mut runs = 0;
            while runs == 0 || begin.elapsed().as_secs_f64() < TURN_S {
                *value = Some(run(case));
                runs += 1;
            }
            times.push(begin.elapsed().as_secs_f64() / f64::from(runs));
        }
    }
    let timed = |(mut times, value): (Vec<f64>, Option<T>)| {
        times.sort_by(f64::total_cmp);
        Some(Timed { value: value?, cpu_s: times[times.len() / 2] })
    };
    times.into_iter().zip(values).filter_map(timed).collect()
}

/// Exponent `p` of the least-squares fit of `y = a x^p`.
pub fn exponent(points: &[(f64, f64)]) -> f64 {
    let n = points.len() as f64;
    let logs = || points.iter().map(|(x, y)| (x.ln(), y.ln()));
    let (mx, my) = (logs().map(|(x, _)| x).sum::<f64>() / n, logs().map(|(_, y)| y).sum::<f64>() / n);
    let (covariance, variance) =
        logs().fold((0.0, 0.0), |(c, v), (x, y)| (c + (x - mx) * (y - my), v + (x - mx) * (x - mx)));
    covariance / variance
}
