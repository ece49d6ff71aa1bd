//! Text into operations, by recursive descent.
//!
//! sum = product {(+|−) product}; product = signed {(*|/) signed}; signed = − signed | power; power = atom [^ signed];
//! atom = number | name | name(sum, …) | (sum). So −x^2 is −(x²) and 2^3^2 is 2^(3²).

use super::{Binary, Expression, Number, Operation, Unary};

/// What is wrong with an expression.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ExpressionError {
    /// The byte of the text that it is about.
    pub at: usize,
    /// What is wrong; what to do.
    pub what: String,
}

/// The longest text, bytes.
const LONGEST: usize = 4096;
/// How deep brackets and signs may be nested: each is a call of the parser in itself.
const DEEPEST: u32 = 64;

const CONSTANTS: &[(&str, f64)] =
    &[("pi", std::f64::consts::PI), ("tau", std::f64::consts::TAU), ("e", std::f64::consts::E)];

const UNARY: &[(&str, Unary)] = &[
    ("sin", Unary::Sin),
    ("cos", Unary::Cos),
    ("tan", Unary::Tan),
    ("exp", Unary::Exp),
    ("log", Unary::Log),
    ("sqrt", Unary::Sqrt),
    ("abs", Unary::Abs),
];

const BINARY: &[(&str, Binary)] = &[("min", Binary::Min), ("max", Binary::Max), ("atan2", Binary::Atan2)];

/// Parses a whole text.
pub(super) fn expression(text: &str, variables: &[&str]) -> Result<Expression, ExpressionError> {
    let mut parser = Parser { text, at: 0, depth: 0, variables, operations: Vec::new(), used: 0 };
    if text.len() > LONGEST {
        return Err(parser.error(0, format!("{} bytes are too many; keep it under {LONGEST}", text.len())));
    }
    let result = parser.sum()?;
    if let Some(other) = parser.peek() {
        let what = if other == ')' {
            "this `)` closes nothing; leave it out".to_owned()
        } else {
            format!("`{other}` is not expected here; write an operator (+ - * / ^) before it, or leave it out")
        };
        return Err(parser.error(parser.at, what));
    }
    // The result is the last operation; what folding left behind it is not needed.
    parser.operations.truncate(result + 1);
    Ok(Expression { text: text.to_owned(), operations: parser.operations, variables: parser.used })
}

struct Parser<'a> {
    text: &'a str,
    at: usize,
    depth: u32,
    variables: &'a [&'a str],
    operations: Vec<Operation>,
    used: u32,
}

type Parsed = Result<usize, ExpressionError>;

impl Parser<'_> {
    fn error(&self, at: usize, what: impl Into<String>) -> ExpressionError {
        ExpressionError { at, what: what.into() }
    }

    /// The next character that is no space; stands before it.
    fn peek(&mut self) -> Option<char> {
        let rest = &self.text[self.at..];
        self.at += rest.len() - rest.trim_start().len();
        self.text[self.at..].chars().next()
    }

    /// Steps over `wanted` if it is next.
    fn take(&mut self, wanted: char) -> bool {
        let is_next = self.peek() == Some(wanted);
        if is_next {
            self.at += wanted.len_utf8();
        }
        is_next
    }

    /// The number of this operation: an earlier one if it was there already; folded where it is constant.
    fn push(&mut self, operation: Operation) -> usize {
        let constant = |i: usize| match self.operations[i] {
            Operation::Constant(value) => Some(value),
            _ => None,
        };
        let folded = match operation {
            Operation::Unary(function, a) => constant(a).map(|a| a.unary(function)),
            Operation::Binary(function, a, b) => constant(a).zip(constant(b)).map(|(a, b)| a.binary(function, b)),
            Operation::Power(a, power) => constant(a).map(|a| a.power(power)),
            Operation::Constant(_) | Operation::Variable(_) => None,
        };
        let operation = folded.map_or(operation, Operation::Constant);
        if let Some(known) = self.operations.iter().position(|o| *o == operation) {
            return known;
        }
        self.operations.push(operation);
        self.operations.len() - 1
    }

    fn sum(&mut self) -> Parsed {
        let mut a = self.product()?;
        loop {
            let function = match self.peek() {
                Some('+') => Binary::Add,
                Some('-') => Binary::Subtract,
                _ => return Ok(a),
            };
            self.at += 1;
            let b = self.product()?;
            a = self.push(Operation::Binary(function, a, b));
        }
    }

    fn product(&mut self) -> Parsed {
        let mut a = self.signed()?;
        loop {
            let function = match self.peek() {
                Some('*') => Binary::Multiply,
                Some('/') => Binary::Divide,
                _ => return Ok(a),
            };
            let operator = self.at;
            self.at += 1;
            let b = self.signed()?;
            if function == Binary::Divide && self.operations[b] == Operation::Constant(0.0) {
                return Err(self.error(operator, "this divides by zero; write another divisor"));
            }
            a = self.push(Operation::Binary(function, a, b));
        }
    }

    fn signed(&mut self) -> Parsed {
        self.depth += 1;
        if self.depth > DEEPEST {
            return Err(self.error(self.at, format!("nested deeper than {DEEPEST}; write it with fewer brackets")));
        }
        let result = if self.take('-') {
            let a = self.signed()?;
            self.push(Operation::Unary(Unary::Negate, a))
        } else if self.take('+') {
            self.signed()?
        } else {
            self.power()?
        };
        self.depth -= 1;
        Ok(result)
    }

    fn power(&mut self) -> Parsed {
        let base = self.atom()?;
        if !self.take('^') {
            return Ok(base);
        }
        let exponent = self.signed()?;
        #[expect(clippy::cast_possible_truncation, reason = "whole and at most 64")]
        if let Operation::Constant(power) = self.operations[exponent]
            && power.fract() == 0.0
            && power.abs() <= 64.0
        {
            return Ok(self.push(Operation::Power(base, power as i32)));
        }
        Ok(self.push(Operation::Binary(Binary::Power, base, exponent)))
    }

    fn atom(&mut self) -> Parsed {
        match self.peek() {
            Some('(') => {
                let open = self.at;
                self.at += 1;
                let inner = self.sum()?;
                self.close(open)?;
                Ok(inner)
            }
            Some(c) if c.is_ascii_digit() || c == '.' => self.number(),
            Some(c) if c.is_alphabetic() || c == '_' => self.name(),
            Some(c) => Err(self.error(self.at, format!("`{c}` is no value; write a number, a name or a bracket"))),
            None => Err(self.error(self.at, "the expression ends too early; write a number, a name or a bracket here")),
        }
    }

    fn close(&mut self, open: usize) -> Result<(), ExpressionError> {
        if self.take(')') {
            return Ok(());
        }
        match self.peek() {
            Some(_) => Err(self.error(self.at, "an operator (+ - * / ^) or `)` is missing before this")),
            None => Err(self.error(open, "this bracket is not closed; write `)`")),
        }
    }

    fn number(&mut self) -> Parsed {
        let start = self.at;
        let bytes = self.text.as_bytes();
        let digits = |mut at: usize| {
            while bytes.get(at).is_some_and(|b| b.is_ascii_digit() || *b == b'.') {
                at += 1;
            }
            at
        };
        let mut end = digits(start);
        if bytes.get(end).is_some_and(|b| b.eq_ignore_ascii_case(&b'e')) {
            let sign = usize::from(bytes.get(end + 1).is_some_and(|b| matches!(b, b'+' | b'-')));
            if bytes.get(end + 1 + sign).is_some_and(u8::is_ascii_digit) {
                end = digits(end + 1 + sign);
            }
        }
        self.at = end;
        let text = &self.text[start..end];
        match text.parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(self.push(Operation::Constant(value))),
            Ok(_) => Err(self.error(start, format!("`{text}` is too large for a number; write a smaller one"))),
            Err(_) => Err(self.error(start, format!("`{text}` is no number; write it like 1.5 or 2e-3"))),
        }
    }

    fn name(&mut self) -> Parsed {
        let start = self.at;
        let rest = &self.text[start..];
        let length = rest.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(rest.len());
        let name = &rest[..length];
        self.at += length;
        if self.peek() == Some('(') {
            return self.call(name, start);
        }
        if let Some(index) = self.variables.iter().position(|v| *v == name) {
            self.used |= 1 << index;
            return Ok(self.push(Operation::Variable(index)));
        }
        if let Some((_, value)) = CONSTANTS.iter().find(|(constant, _)| *constant == name) {
            return Ok(self.push(Operation::Constant(*value)));
        }
        if UNARY.iter().any(|(f, _)| *f == name) || BINARY.iter().any(|(f, _)| *f == name) {
            return Err(self.error(start, format!("the function `{name}` has no brackets; write {name}(…)")));
        }
        let known = self.variables.iter().copied().chain(CONSTANTS.iter().map(|(c, _)| *c)).collect::<Vec<_>>();
        Err(self.error(start, format!("unknown name `{name}`; choose {}", known.join(", "))))
    }

    fn call(&mut self, name: &str, start: usize) -> Parsed {
        let unary = UNARY.iter().find(|(f, _)| *f == name).map(|(_, function)| *function);
        let binary = BINARY.iter().find(|(f, _)| *f == name).map(|(_, function)| *function);
        if unary.is_none() && binary.is_none() {
            let known: Vec<&str> = UNARY.iter().map(|(f, _)| *f).chain(BINARY.iter().map(|(f, _)| *f)).collect();
            return Err(self.error(start, format!("unknown function `{name}`; choose {}", known.join(", "))));
        }
        let open = self.at;
        self.at += 1;
        let a = self.sum()?;
        let result = match (unary, binary) {
            (Some(function), _) => self.push(Operation::Unary(function, a)),
            (None, Some(function)) => {
                if !self.take(',') {
                    return Err(self.error(self.at, format!("`{name}` takes two values; write {name}(a, b)")));
                }
                let b = self.sum()?;
                self.push(Operation::Binary(function, a, b))
            }
            (None, None) => a,
        };
        if self.peek() == Some(',') {
            let count = if unary.is_some() { "one value" } else { "two values" };
            return Err(self.error(self.at, format!("`{name}` takes {count}; leave the rest out")));
        }
        self.close(open)?;
        Ok(result)
    }
}
