//! Expressions mean what mathematics means by them, and so do their derivatives and bounds.

use murrine::scene::expression::{Dual, Expression, Interval, Lanes, Number};
use murrine::scene::file;
use std::path::Path;

const NAMES: [&str; 2] = ["x", "y"];

fn value(text: &str, x: f64, y: f64) -> f64 {
    Expression::parse(text, &NAMES).unwrap_or_else(|e| panic!("{text}: {e:?}")).evaluate(&[x, y], &mut Vec::new())
}

#[test]
fn expressions_follow_the_rules_of_precedence() {
    let cases = [
        ("1 + 2*3", 7.0),
        ("-x^2", -4.0),
        ("2^3^2", 512.0),
        ("x^-1", 0.5),
        ("10 - 4 - 3", 3.0),
        ("12/3/2", 2.0),
        ("-(-x)", 2.0),
        ("2*-x", -4.0),
        ("(x + y)*(x - y)", -5.0),
        ("min(x, y) + max(x, y)*10", 32.0),
        ("atan2(y, -x)", 3.0_f64.atan2(-2.0)),
        ("abs(x - y) + sqrt(x^2 + y^2 + 3)", 5.0),
        ("exp(log(x)*y) - x^y", 0.0),
        ("sin(pi/6) + cos(tau) + tan(0)", 1.5),
        ("1.5e1 + .5 + 2E-1", 15.7),
    ];
    for (text, expected) in cases {
        assert!((value(text, 2.0, 3.0) - expected).abs() < 1e-12, "{text} is {}", value(text, 2.0, 3.0));
    }
}

const SMOOTH: [&str; 14] = [
    "x^4 - 5*x^2 + y",
    "x*y/(1 + x^2)",
    "sin(x*y) + cos(2*x - y)",
    "tan(0.3*x)",
    "exp(-x^2 - y^2)",
    "log(2 + x + y)",
    "sqrt(4 + x*y)",
    "abs(x - 0.1)*y",
    "min(x, y^2)",
    "max(sin(x), y)",
    "atan2(x + 2, y + 3)",
    "(3 + x)^y",
    "(3 + x)^2.5",
    "(3 + x)^-3",
];

/// Evenly spread pseudo-random numbers from −1 to 1.
fn spread(i: u32) -> f64 {
    (f64::from(i) * 0.618_033_988_749_895).fract() * 2.0 - 1.0
}

#[test]
fn derivatives_are_those_of_small_steps() {
    for text in SMOOTH {
        let expression = Expression::parse(text, &NAMES).unwrap();
        for i in 0..40 {
            let (x, y) = (spread(i), spread(7 * i + 3));
            let dual = expression.evaluate(&[Dual::<2>::variable(x, 0), Dual::variable(y, 1)], &mut Vec::new());
            let h = 1e-6;
            let by_steps = [
                (value(text, x + h, y) - value(text, x - h, y)) / (2.0 * h),
                (value(text, x, y + h) - value(text, x, y - h)) / (2.0 * h),
            ];
            assert!((dual.value - value(text, x, y)).abs() < 1e-12, "{text}");
            for (slope, step) in dual.slopes.iter().zip(by_steps) {
                assert!((slope - step).abs() < 1e-5 * (1.0 + step.abs()), "{text} at {x} {y}: {slope}, not {step}");
            }
        }
    }
}

#[test]
fn bounds_over_a_box_hold_every_value_in_it() {
    let mut narrowed = 0;
    for text in SMOOTH.into_iter().chain(["1/x", "sqrt(x)", "log(y)", "atan2(y, x)", "tan(3*x)", "x^-2", "cos(9*x)"]) {
        let expression = Expression::parse(text, &NAMES).unwrap();
        for i in 0..30 {
            let (x, y, half) = (spread(i), spread(5 * i + 1), 0.02 + 0.3 * spread(3 * i).abs());
            let side = |c: f64| Interval { low: c - half, high: c + half };
            let bounds = expression.evaluate(&[side(x), side(y)], &mut Vec::new());
            for j in 0..50 {
                let there = value(text, x + half * spread(j), y + half * spread(11 * j + 5));
                if there.is_nan() {
                    assert_eq!(bounds, Interval::ALL, "{text} may be no number");
                    continue;
                }
                let room = 1e-9 * there.abs();
                assert!(bounds.low - room <= there && there <= bounds.high + room, "{text}: {there} of {bounds:?}");
                let middle = 0.5 * (bounds.low + bounds.high);
                narrowed += usize::from(there < middle);
            }
        }
    }
    assert!(narrowed > 1000, "half the bounds must not hold: {narrowed}");
}

#[test]
fn eight_values_at_a_time_are_the_same_eight_values() {
    for text in SMOOTH {
        let expression = Expression::parse(text, &NAMES).unwrap();
        let x: [f64; Lanes::COUNT] = std::array::from_fn(|i| 0.2 * i as f64 - 0.7);
        let together = expression.evaluate(&[Lanes(x), Lanes::constant(0.4)], &mut Vec::new());
        for (x, here) in x.into_iter().zip(together.0) {
            assert!((here - value(text, x, 0.4)).abs() <= 1e-14 * here.abs().max(1.0), "{text}");
        }
    }
}

#[test]
fn a_wrong_expression_is_refused_at_its_character_with_a_remedy() {
    let cases = [
        ("x^2 + q", 7, "unknown name `q`"),
        ("x^2 + (y", 7, "not closed"),
        ("x^2 + y)", 8, "closes nothing"),
        ("x +", 4, "ends too early"),
        ("sinn(x)", 1, "unknown function `sinn`"),
        ("sin x", 1, "has no brackets"),
        ("2 x", 3, "not expected here"),
        ("min(x)", 6, "takes two values"),
        ("sin(x, y)", 6, "takes one value"),
        ("x * / y", 5, "is no value"),
        ("1/(2 - 2)", 2, "divides by zero"),
        ("1.2.3", 1, "is no number"),
        ("u + x", 1, "unknown name `u`"),
    ];
    for (text, column, expected) in cases {
        let line = format!("expression = \"{text}\"");
        let scene = format!("[[model]]\nshape = \"implicit\"\n{line}\n");
        let error = file::parse(&scene, Path::new("a.toml"), &["hybrid"]).unwrap_err().to_string();
        let column = column + "expression = \"".len();
        assert!(error.starts_with(&format!("a.toml:3:{column}:")), "{text}: {error}");
        assert!(error.contains(expected) && error.contains("; ") && error.contains('→'), "{text}: {error}");
    }
    let deep = format!("[[model]]\nshape = \"implicit\"\nexpression = \"{}x\"\n", "(".repeat(4000));
    let error = file::parse(&deep, Path::new("a.toml"), &["hybrid"]).unwrap_err().to_string();
    assert!(error.contains("nested deeper"), "{error}");
}
