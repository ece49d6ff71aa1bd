//! Expressions of a scene file, such as `x^4 + sin(2*t)`: parsed once, evaluated with any kind of [`Number`].
//!
//! An expression is kept as a list of operations, each on the results of earlier ones; what occurs twice is worked out
//! once. Evaluated with plain numbers it gives a value, with [`Dual`] its derivatives too (automatic differentiation),
//! with [`Interval`] bounds of all values over a box, with [`Lanes`] eight values at a time.

mod number;
mod parse;

pub use number::{Dual, Interval, Lanes, Number};
pub use parse::ExpressionError;

/// A parsed expression. Two are equal when their texts are.
#[derive(Debug, Clone)]
pub struct Expression {
    text: String,
    operations: Vec<Operation>,
    variables: u32,
}

/// One step; operands are numbers of earlier steps.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Operation {
    Constant(f64),
    Variable(usize),
    Unary(Unary, usize),
    Binary(Binary, usize, usize),
    /// To a whole power.
    Power(usize, i32),
}

/// Functions of one number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unary {
    /// −a.
    Negate,
    /// |a|.
    Abs,
    /// √a.
    Sqrt,
    /// eᵃ.
    Exp,
    /// Natural logarithm.
    Log,
    /// Of radians.
    Sin,
    /// Of radians.
    Cos,
    /// Of radians.
    Tan,
}

/// Functions of two numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Binary {
    /// a + b.
    Add,
    /// a − b.
    Subtract,
    /// a · b.
    Multiply,
    /// a / b.
    Divide,
    /// aᵇ = exp(b·log a), for a > 0.
    Power,
    /// The lesser.
    Min,
    /// The greater.
    Max,
    /// The angle of (x = b, y = a), −π … π.
    Atan2,
}

impl Expression {
    /// Parses `text`, in which the names of `variables` stand for the numbers that [`Expression::evaluate`] is given.
    ///
    /// # Errors
    /// The byte that is wrong, what is wrong there and what to do.
    pub fn parse(text: &str, variables: &[&str]) -> Result<Self, ExpressionError> {
        parse::expression(text, variables)
    }

    /// As it was written.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Whether the variable of this index occurs.
    #[must_use]
    pub fn uses(&self, variable: usize) -> bool {
        self.variables >> variable & 1 == 1
    }

    /// The value for these variables. `steps` is room for what is worked out on the way, to be used again and again.
    pub fn evaluate<N: Number>(&self, variables: &[N], steps: &mut Vec<N>) -> N {
        steps.clear();
        for operation in &self.operations {
            steps.push(match *operation {
                Operation::Constant(value) => N::constant(value),
                Operation::Variable(index) => variables[index],
                Operation::Unary(function, a) => steps[a].unary(function),
                Operation::Binary(function, a, b) => steps[a].binary(function, steps[b]),
                Operation::Power(a, power) => steps[a].power(power),
            });
        }
        steps.last().copied().unwrap_or(N::constant(0.0))
    }
}

impl PartialEq for Expression {
    fn eq(&self, other: &Self) -> bool {
        self.text == other.text
    }
}
