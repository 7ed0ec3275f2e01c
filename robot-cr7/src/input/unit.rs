//! Units that files may be written in.

/// Radians per degree.
pub(crate) const DEGREE: f64 = std::f64::consts::PI / 180.0;

/// A unit of length of a file; inside the program everything is in metres.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LengthUnit {
    /// Millimetre, `"mm"`.
    Millimetre,
    /// Centimetre, `"cm"`.
    Centimetre,
    /// Metre, `"m"`.
    Metre,
    /// Inch of 25.4 mm, `"in"`.
    Inch,
}

impl LengthUnit {
    /// The unit written as `symbol`, if it is a known one.
    ///
    /// ```
    /// use robot_cr7::LengthUnit;
    /// assert_eq!(LengthUnit::from_symbol("mm"), Some(LengthUnit::Millimetre));
    /// assert_eq!(LengthUnit::from_symbol("parsec"), None);
    /// ```
    pub fn from_symbol(symbol: &str) -> Option<Self> {
        match symbol {
            "mm" => Some(Self::Millimetre),
            "cm" => Some(Self::Centimetre),
            "m" => Some(Self::Metre),
            "in" => Some(Self::Inch),
            _ => None,
        }
    }

    /// The symbol of the unit in files.
    pub fn symbol(self) -> &'static str {
        match self {
            Self::Millimetre => "mm",
            Self::Centimetre => "cm",
            Self::Metre => "m",
            Self::Inch => "in",
        }
    }

    /// A length in this unit, in metres.
    ///
    /// Divides by a whole number where it can, so that 54.493 mm becomes the double next to 0.054493 m.
    pub fn to_metres(self, value: f64) -> f64 {
        match self {
            Self::Millimetre => value / 1000.0,
            Self::Centimetre => value / 100.0,
            Self::Metre => value,
            Self::Inch => value * 25.4 / 1000.0,
        }
    }
}
