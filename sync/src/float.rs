//! Functions of `f64` that the standard library has and `core` lacks.

/// The functions of `f64` by the names of the standard library.
pub(crate) trait Float: Sized {
    fn sqrt(self) -> Self;
    fn cbrt(self) -> Self;
    fn powi(self, exponent: i32) -> Self;
    fn ceil(self) -> Self;
    fn round(self) -> Self;
    fn sin(self) -> Self;
    fn cos(self) -> Self;
    fn sin_cos(self) -> (Self, Self);
    fn atan2(self, other: Self) -> Self;
    fn hypot(self, other: Self) -> Self;
}

impl Float for f64 {
    fn sqrt(self) -> Self {
        libm::sqrt(self)
    }

    fn cbrt(self) -> Self {
        libm::cbrt(self)
    }

    fn powi(self, exponent: i32) -> Self {
        let power = (0..exponent.unsigned_abs()).fold(1.0, |power, _| power * self);
        if exponent < 0 { 1.0 / power } else { power }
    }

    fn ceil(self) -> Self {
        libm::ceil(self)
    }

    fn round(self) -> Self {
        libm::round(self)
    }

    fn sin(self) -> Self {
        libm::sin(self)
    }

    fn cos(self) -> Self {
        libm::cos(self)
    }

    fn sin_cos(self) -> (Self, Self) {
        libm::sincos(self)
    }

    fn atan2(self, other: Self) -> Self {
        libm::atan2(self, other)
    }

    fn hypot(self, other: Self) -> Self {
        libm::hypot(self, other)
    }
}
