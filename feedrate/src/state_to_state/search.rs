//! Roots and minima of functions of one variable between 0 and 1, in a bounded number of steps.

/// Steps that bring a root to neighbouring numbers, but for the last digits.
const ROOT_STEPS: usize = 40;

/// Roots that are looked for.
pub(super) const MOST_ROOTS: usize = 3;

/// One golden section of an interval.
const GOLDEN: f64 = 0.381_966_011_250_105_1;

/// A change of the place that is not looked at any more.
const LEAST_STEP: f64 = 1e-6;

/// The first step to a place beyond, as a part of it, and the steps after that.
const PROBE: f64 = 1e-3;
const SECANTS: usize = 6;

/// A boundary as near as this is found.
const LEAST_WIDTH: f64 = 1e-14;

/// A place and the value of a function there.
#[derive(Debug, Clone, Copy)]
pub(super) struct Value {
    pub at: f64,
    pub value: f64,
}

impl Value {
    /// The lesser one of this and of the value in another place, of which NaN is none.
    pub fn or(self, at: f64, f: impl Fn(f64) -> f64) -> Self {
        let value = if at.is_nan() { f64::INFINITY } else { f(at) };
        if value < self.value { Self { at, value } } else { self }
    }
}

/// The first roots of `f` between neighbouring places, which are in order; NaN for none. Of the two
/// numbers between which a root lies it is the one where `time` is shorter.
pub(super) fn roots(f: impl Fn(f64) -> f64, time: impl Fn(f64) -> f64, places: &[f64]) -> [f64; MOST_ROOTS] {
    let mut found = [f64::NAN; MOST_ROOTS];
    let mut count = 0;
    let mut last: Option<Value> = None;
    for &at in places {
        let to = Value { at, value: f(at) };
        if let Some(from) = last
            && (from.value < 0.0 && to.value >= 0.0 || from.value >= 0.0 && to.value < 0.0)
        {
            let (x, y) = root(&f, from, to);
            found[count] = if time(y) < time(x) { y } else { x };
            count += 1;
            if count == MOST_ROOTS {
                break;
            }
        }
        last = Some(to);
    }
    found
}

/// The two numbers, as near as they get, between which `f` changes its sign: the Illinois method,
/// with a bisection after each step that does not halve the interval.
fn root(f: &impl Fn(f64) -> f64, from: Value, to: Value) -> (f64, f64) {
    let (mut x, mut y) = (from, to);
    let (mut bisect, mut last) = (false, None);
    for _ in 0..ROOT_STEPS {
        let width = y.at - x.at;
        let chord = x.at - x.value * width / (y.value - x.value);
        let middle = x.at + 0.5 * width;
        let inside = chord > x.at && chord < y.at;
        let at = if bisect || !inside { middle } else { chord };
        if at <= x.at || at >= y.at {
            break;
        }
        let new = Value { at, value: f(at) };
        let low = (new.value < 0.0) == (x.value < 0.0);
        let again = if last == Some(low) { 0.5 } else { 1.0 };
        if low {
            (x, y.value) = (new, again * y.value);
        } else {
            (y, x.value) = (new, again * x.value);
        }
        last = Some(low);
        bisect = y.at - x.at > 0.5 * width;
    }
    (x.at, y.at)
}

/// The place farthest from `inside` towards `outside` where `excess` is not above 0, as far as so many
/// steps get: secants through the last two places outside, bisections where they are of no use.
pub(super) fn boundary(excess: impl Fn(f64) -> f64, (mut inside, outside): (f64, f64), steps: usize) -> f64 {
    let mut nearest = Value { at: outside, value: excess(outside) };
    let mut last = nearest;
    for _ in 0..steps {
        let secant = nearest.at - nearest.value * (nearest.at - last.at) / (nearest.value - last.value);
        let useful = (secant - inside) * (secant - nearest.at) < 0.0;
        let at = if useful { secant } else { 0.5 * (inside + nearest.at) };
        if (nearest.at - inside).abs() < LEAST_WIDTH || at == inside || at == nearest.at {
            break;
        }
        let new = Value { at, value: excess(at) };
        if new.value <= 0.0 {
            inside = at;
        } else {
            (last, nearest) = (nearest, new);
        }
    }
    inside
}

/// The first place above `from` where an excess has fallen to 0, by secants; `from` itself where it is
/// none, or falls nowhere.
pub(super) fn beyond(excess: impl Fn(f64) -> f64, from: f64) -> f64 {
    let mut last = Value { at: from, value: excess(from) };
    let mut at = (from * (1.0 + PROBE)).min(1.0);
    for _ in 0..SECANTS {
        if last.value <= 0.0 {
            return last.at;
        }
        let new = Value { at, value: excess(at) };
        let secant = new.at - new.value * (new.at - last.at) / (new.value - last.value);
        if new.value > 0.0 && !(secant > new.at && secant <= 1.0) {
            return from;
        }
        (last, at) = (new, secant);
    }
    if last.value <= 0.0 { last.at } else { from }
}

/// The least value that a search of so many steps finds in an interval, from a place with a known
/// value on: Brent's method, with golden sections where a value is infinite.
pub(super) fn minimise(f: impl Fn(f64) -> f64, from: Value, (mut lo, mut hi): (f64, f64), steps: usize) -> Value {
    // The best place, the second best and the one before.
    let (mut x, mut w, mut v) = (from, from, from);
    let (mut step, mut before) = (0.0_f64, 0.0_f64);
    for _ in 0..steps {
        let (r, q) = ((x.at - w.at) * (x.value - v.value), (x.at - v.at) * (x.value - w.value));
        let parabola = -0.5 * ((x.at - v.at) * q - (x.at - w.at) * r) / (q - r);
        let next = x.at + parabola;
        let useful = next > lo && next < hi && parabola.abs() < 0.5 * before.abs();
        let longer = if x.at < 0.5 * (lo + hi) { hi - x.at } else { lo - x.at };
        (before, step) = if useful { (step, parabola) } else { (longer, GOLDEN * longer) };
        if step.abs() < LEAST_STEP {
            break;
        }
        let new = Value { at: x.at + step, value: f(x.at + step) };
        let below = new.at < x.at;
        if new.value <= x.value {
            if below {
                hi = x.at
            } else {
                lo = x.at
            }
            (v, w, x) = (w, x, new);
        } else {
            if below {
                lo = new.at
            } else {
                hi = new.at
            }
            if new.value <= w.value || w.at == x.at {
                (v, w) = (w, new);
            } else if new.value <= v.value || v.at == x.at || v.at == w.at {
                v = new;
            }
        }
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Golden sections alone would leave a hundredth of the interval after so many steps.
    #[test]
    fn the_least_value_of_a_smooth_function_is_found_by_parabolas() {
        for least in [0.05, 0.3, 0.62, 0.9] {
            let f = |x: f64| (x - least).powi(2) * (1.0 + 0.3 * (x - least));
            let found = minimise(f, Value { at: 0.5, value: f(0.5) }, (0.0, 1.0), 10);
            assert!((found.at - least).abs() < 1e-4, "{} instead of {least}", found.at);
            assert_eq!(found.value, f(found.at));
        }
    }
}
