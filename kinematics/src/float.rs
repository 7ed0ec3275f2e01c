//! Functions of `f64` that the standard library has and `core` lacks.

/// The functions of `f64` by the names of the standard library.
pub(crate) trait Float: Sized {
    fn sqrt(self) -> Self;
    fn sin(self) -> Self;
    fn cos(self) -> Self;
    fn sin_cos(self) -> (Self, Self);
    fn atan2(self, other: Self) -> Self;
    fn hypot(self, other: Self) -> Self;
    fn acos(self) -> Self;
}

impl Float for f64 {
    fn sqrt(self) -> Self {
        libm::sqrt(self)
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

    fn acos(self) -> Self {
        libm::acos(self)
    }
}
