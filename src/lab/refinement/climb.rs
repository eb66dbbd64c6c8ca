//! Climbs from a place to the nearest peak of a criterion.

/// Candidates from which peaks are climbed to.
const STARTS: usize = 5;
/// Smallest distance between them along one factor, as a share of its range.
const APART: f64 = 0.1;
/// Largest distance of a peak from its candidate along each factor. A model of few rows has its highest peaks at the corners of the ranges,
/// where it is least certain.
const CLIMBED: f64 = 0.03;
/// First step along each factor, as a share of its range.
const FIRST_STEP: f64 = 0.05;
/// Step below which a peak is reached.
const LEAST_STEP: f64 = 1e-6;
/// Steps of the next round along the last one's direction, as multiples of it.
const FURTHER: [f64; 2] = [1.0, 3.0];
/// Rounds at most.
const MOST_ROUNDS: usize = 200;

/// Smallest distance of a row from all others along one factor, as a share of its range. If a model is nearly certain, its peaks are close
/// to rows, and a copy of a row adds no information. An output that scatters shows it at this distance too. Three times as much would
/// prevent the third digit of an optimum.
pub const LEAST_DISTANCE: f64 = 1e-3;
/// Share of it by which rounding may make it less.
const ROUNDING: f64 = 1e-9;

/// A place by the shares of the factors' ranges, 0 to 1, and the value of a criterion there.
#[derive(Debug, Clone, PartialEq)]
pub struct Peak {
    /// The shares.
    pub at: Vec<f64>,
    /// The criterion there.
    pub merit: f64,
}

/// A criterion of several places at once.
pub type Merits<'m, E> = dyn FnMut(&[Vec<f64>]) -> Result<Vec<f64>, E> + 'm;

/// The highest of the peaks of `merits` that lie near the best candidates, which are given by their shares of the ranges and their merits:
/// a few of the best that lie apart are climbed from, each over a short way. `None` without candidates.
///
/// # Errors
/// Those of `merits`.
pub fn highest_peak<E>(candidates: (&[Vec<f64>], &[f64]), merits: &mut Merits<'_, E>) -> Result<Option<Peak>, E> {
    let mut highest: Option<Peak> = None;
    for start in starts(candidates) {
        let at = start.at.clone();
        let mut near = |places: &[Vec<f64>]| {
            let is_near = |place: &&Vec<f64>| farthest(&at, place) <= CLIMBED;
            let mut found = merits(&places.iter().filter(is_near).cloned().collect::<Vec<_>>())?.into_iter();
            let merit = |place| is_near(&place).then(|| found.next()).flatten().unwrap_or(f64::NEG_INFINITY);
            Ok(places.iter().map(merit).collect())
        };
        let peak = climb(start, &mut near)?;
        if highest.as_ref().is_none_or(|highest| peak.merit > highest.merit) {
            highest = Some(peak);
        }
    }
    Ok(highest)
}

/// The candidates to climb from, the best first.
fn starts((places, merits): (&[Vec<f64>], &[f64])) -> Vec<Peak> {
    let mut order: Vec<usize> = (0..merits.len()).collect();
    order.sort_by(|a, b| merits[*b].total_cmp(&merits[*a]).then(a.cmp(b)));
    let mut starts: Vec<Peak> = Vec::new();
    for place in order {
        let at = &places[place];
        if starts.len() < STARTS && starts.iter().all(|start| farthest(&start.at, at) > APART) {
            starts.push(Peak { at: at.clone(), merit: merits[place] });
        }
    }
    starts
}

/// Distance of two places along the factor in which they differ most.
fn farthest(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()))
}

/// Whether a place lies so far from other ones, all given by their shares of the ranges, along one factor at least.
pub fn is_apart(at: &[f64], others: &[Vec<f64>], distance: f64) -> bool {
    others.iter().all(|other| farthest(other, at) >= (1.0 - ROUNDING) * distance)
}

/// Climbs from a place to a peak of `merits`, a criterion that is evaluated at several places at once. It is `f64::NEG_INFINITY` at
/// forbidden places, so that constraints hold on the way and at the end.
///
/// A pattern search (Hooke and Jeeves, J. ACM 8, 1961): a step to both sides along each factor, then one along all of them to the tops of
/// the parabolas through these, one along the slope that they show, and on along the last round's way. The best of them is the next
/// place; where none is better, the step is a quarter. No derivative is requested: factors may have levels, and a constraint may cut the
/// ranges anywhere.
///
/// # Errors
/// Those of `merits`.
fn climb<E>(from: Peak, merits: &mut Merits<'_, E>) -> Result<Peak, E> {
    let (mut peak, mut step) = (from, FIRST_STEP);
    let mut last: Option<Vec<f64>> = None;
    for _ in 0..MOST_ROUNDS {
        if step < LEAST_STEP {
            break;
        }
        let sides: Vec<Vec<f64>> = (0..2 * peak.at.len())
            .map(|side| {
                let away = if side % 2 == 0 { step } else { -step };
                let mut to = peak.at.clone();
                to[side / 2] = (to[side / 2] + away).clamp(0.0, 1.0);
                to
            })
            .collect();
        let found = merits(&sides)?;
        // Along a factor at its bound, the sides give no slope.
        let slope = |sides: &[f64]| Some(sides[0] - sides[1]).filter(|slope| slope.is_finite()).unwrap_or(0.0);
        let slopes: Vec<f64> = found.chunks_exact(2).map(slope).collect();
        let steepest = slopes.iter().fold(0.0, |most: f64, slope| most.max(slope.abs()));
        let tops = found.chunks_exact(2).map(|sides| step * top([sides[1], peak.merit, sides[0]])).collect();
        let mut ways: Vec<Vec<f64>> = vec![tops];
        if steepest > 0.0 {
            ways.push(slopes.iter().map(|slope| step * slope / steepest).collect());
        }
        if let Some(last) = last.take() {
            let further = |times: f64| peak.at.iter().zip(&last).map(|(at, last)| times * (at - last)).collect();
            ways.extend(FURTHER.map(further));
        }
        let to = |way: &Vec<f64>| peak.at.iter().zip(way).map(|(at, way)| (at + way).clamp(0.0, 1.0)).collect();
        let beyond: Vec<Vec<f64>> = ways.iter().map(to).collect();
        let merits_beyond = merits(&beyond)?;
        let all = sides.into_iter().chain(beyond).zip(found.into_iter().chain(merits_beyond));
        let best = all.fold(None, |best: Option<Peak>, (at, merit)| match best {
            Some(best) if best.merit >= merit => Some(best),
            _ => Some(Peak { at, merit }),
        });
        match best {
            Some(best) if best.merit > peak.merit => {
                last = Some(peak.at);
                peak = best;
            }
            _ => step *= 0.25,
        }
    }
    Ok(peak)
}

/// Maximum of the parabola through the values at -1, 0 and 1, at most 2 away; the better side if it has no maximum.
fn top([left, middle, right]: [f64; 3]) -> f64 {
    let bend = left - 2.0 * middle + right;
    match bend < 0.0 && bend.is_finite() {
        true => (0.5 * (left - right) / bend).clamp(-2.0, 2.0),
        false if right > left => 1.0,
        false if left > right => -1.0,
        false => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::convert::Infallible;

    fn found(from: &[f64], merit: impl Fn(&[f64]) -> f64) -> Peak {
        let mut merits = |places: &[Vec<f64>]| Ok::<_, Infallible>(places.iter().map(|place| merit(place)).collect());
        let Ok(peak) = climb(Peak { at: from.to_vec(), merit: merit(from) }, &mut merits);
        peak
    }

    #[test]
    fn a_narrow_oblique_ridge_ends_at_its_top() {
        let merit = |x: &[f64]| -((x[0] - 0.7) + (x[1] - 0.4)).powi(2) * 1e3 - ((x[0] - 0.7) - (x[1] - 0.4)).powi(2);
        let peak = found(&[0.2, 0.1], merit);
        assert!((peak.at[0] - 0.7).abs() < 1e-4 && (peak.at[1] - 0.4).abs() < 1e-4, "{peak:?}");
    }

    /// Of two hills the higher one is found from candidates at the foot of both, and none is climbed farther than allowed.
    #[test]
    fn the_highest_peak_near_the_candidates_counts() {
        let hill = |x: f64, at: f64, height: f64| height - 50.0 * (x - at).powi(2);
        let merit = |x: f64| hill(x, 0.2, 1.0).max(hill(x, 0.8, 2.0)).max(hill(x, 0.5, 9.0) - 1e3 * (x - 0.5).abs());
        let places: Vec<Vec<f64>> = [0.21, 0.22, 0.79, 0.45].map(|x| vec![x]).to_vec();
        let merits: Vec<f64> = places.iter().map(|place| merit(place[0])).collect();
        let mut all = |places: &[Vec<f64>]| Ok::<_, Infallible>(places.iter().map(|place| merit(place[0])).collect());
        let Ok(Some(peak)) = highest_peak((&places, &merits), &mut all) else { panic!("no peak") };
        assert!((peak.at[0] - 0.8).abs() < 1e-4 && (peak.merit - 2.0).abs() < 1e-6, "{peak:?}");
        assert_eq!(highest_peak((&[], &[]), &mut all), Ok(None));
    }

    #[test]
    fn copies_of_rows_are_told_from_rows() {
        let rows = [vec![0.5, 0.5], vec![0.0, 1.0]];
        let may_lie = |at: [f64; 2]| is_apart(&at, &rows, LEAST_DISTANCE);
        assert!(may_lie([0.5, 0.501]) && may_lie([0.4, 0.5]) && is_apart(&[0.5, 0.5], &[], LEAST_DISTANCE));
        assert!(!may_lie([0.500_9, 0.499_1]) && !may_lie([0.0, 1.0]));
    }

    #[test]
    fn it_stays_where_it_may_be() {
        let merit = |x: &[f64]| if x[0] + x[1] > 0.9 { f64::NEG_INFINITY } else { x[0] + 2.0 * x[1] - x[1] * x[1] };
        let peak = found(&[0.3, 0.3], merit);
        assert!(peak.at[0] + peak.at[1] <= 0.9 && peak.merit > 1.05 && peak.merit <= 1.150_000_1, "{peak:?}");
        assert_eq!(found(&[0.5], |x| x[0]).at, [1.0]);
    }
}
