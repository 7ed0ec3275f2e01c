//! A printed number and the rounding of its print.

/// A number as it is printed: its value, and half a unit of its last digit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Printed {
    value: f64,
    half_unit: f64,
    decimals: usize,
}

impl Printed {
    /// Reads a plain decimal number such as `0.6000`, `-121` or `1579`; `None` for anything else.
    ///
    /// ```
    /// use robot_cr7::reproduce::Printed;
    ///
    /// let printed = Printed::parse("0.6519").expect("a number");
    /// assert!(printed.agrees(0.651923));
    /// assert!(!printed.agrees(0.65196));
    /// assert!(Printed::parse("yes").is_none());
    /// ```
    pub fn parse(text: &str) -> Option<Self> {
        let plain = |c: char| c.is_ascii_digit() || c == '.' || c == '-';
        if !text.chars().all(plain) {
            return None;
        }
        let value: f64 = text.parse().ok()?;
        let decimals = text.split_once('.').map_or(0, |(_, fraction)| fraction.len());
        let half_unit = 0.5 * 10f64.powi(-i32::try_from(decimals).ok()?);
        Some(Self { value, half_unit, decimals })
    }

    /// Whether `ours` rounds to the print. Round-off of 1e-9 of the unit is allowed.
    pub fn agrees(&self, ours: f64) -> bool {
        (ours - self.value).abs() <= self.half_unit * (1.0 + 2e-9)
    }

    /// The printed value.
    pub fn value(&self) -> f64 {
        self.value
    }

    /// `ours` with two digits more than the print.
    pub fn shown(&self, ours: f64) -> String {
        format!("{ours:.*}", self.decimals + 2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_digit_decides() {
        let agrees = |text: &str, ours: f64| Printed::parse(text).expect("a number").agrees(ours);
        assert!(agrees("0.6000", 0.60004) && !agrees("0.6000", 0.60006));
        assert!(agrees("0.86", 0.8646) && !agrees("0.86", 0.8651));
        assert!(agrees("143", 143.0) && !agrees("143", 144.0));
        assert!(agrees("-121", -121.2) && !agrees("-121", 121.0));
        assert!(!agrees("1", f64::NAN));
        for text in ["", "1e-5", "none", "1.2.3", "nan", "inf"] {
            assert!(Printed::parse(text).is_none(), "{text}");
        }
    }
}
