//! Reads typed, bounded values from a table of a scene file; every complaint names its line and column.
//!
//! A [`Section`] remembers each key that it was asked for, so [`Section::finish`] knows which keys are strangers: the
//! code that reads a key is the only list of keys.

use crate::scene::SceneError;
use crate::scene::csg::{Operation, Tree};
use crate::scene::expression::Expression;
use crate::scene::words::{Words, nearest};
use glam::Vec3;
use std::ops::{Range, RangeInclusive};
use toml_edit::{Item, TableLike, Value};

/// Bytes of the text that a complaint is about.
pub(super) type Span = Option<Range<usize>>;

/// The text that is read and what it is called.
#[derive(Debug, Clone, Copy)]
pub(super) struct Text<'a> {
    pub(super) text: &'a str,
    /// Its file, as messages show it.
    pub(super) name: &'a str,
}

impl Text<'_> {
    /// An error at a span: `file:line:column`, both counted from one, the column in characters.
    pub(super) fn error(&self, span: &Span, what: impl Into<String>) -> SceneError {
        let Some(span) = span else { return SceneError::new(self.name, what) };
        let before = self.text.get(..span.start).unwrap_or(self.text);
        let line = before.matches('\n').count() + 1;
        let column = before.rsplit('\n').next().unwrap_or("").chars().count() + 1;
        SceneError::new(format!("{}:{line}:{column}", self.name), what)
    }
}

/// A table of the file that is being read.
pub(super) struct Section<'a> {
    text: Text<'a>,
    table: &'a dyn TableLike,
    /// What messages call it: `[effect]`, `[[light]] 0`.
    name: String,
    span: Span,
    known: Vec<&'static str>,
}

impl<'a> Section<'a> {
    /// Starts to read `table`; `span` is where it begins.
    pub(super) fn new(text: Text<'a>, table: &'a dyn TableLike, name: impl Into<String>, span: Span) -> Self {
        Self { text, table, name: name.into(), span, known: Vec::new() }
    }

    /// An error about the table as a whole.
    pub(super) fn error(&self, what: impl Into<String>) -> SceneError {
        self.text.error(&self.span, what)
    }

    /// An error about the value of `key` (or the table where there is none).
    pub(super) fn error_at(&self, key: &str, what: impl Into<String>) -> SceneError {
        let span = self.table.get(key).and_then(Item::span).or_else(|| self.span.clone());
        self.text.error(&span, what)
    }

    /// The item of `key`, which becomes a known key.
    fn item(&mut self, key: &'static str) -> Option<&'a Item> {
        if !self.known.contains(&key) {
            self.known.push(key);
        }
        self.table.get(key)
    }

    /// True where the file has this key.
    pub(super) fn has(&self, key: &str) -> bool {
        self.table.contains_key(key)
    }

    /// True where the file has a string under this key.
    pub(super) fn is_string(&self, key: &str) -> bool {
        self.table.get(key).is_some_and(Item::is_str)
    }

    fn wrong_type(&self, key: &str, wanted: &str) -> SceneError {
        let found = self.table.get(key).map_or("nothing", kind_of);
        self.error_at(key, format!("`{key}` is {found}; write {wanted}"))
    }

    /// A number; a whole one counts.
    pub(super) fn number(&mut self, key: &'static str, range: RangeInclusive<f32>) -> Result<Option<f32>, SceneError> {
        let Some(item) = self.item(key) else { return Ok(None) };
        let value = item.as_value().and_then(number_of).ok_or_else(|| self.wrong_type(key, "a number"))?;
        self.within(key, &format!("`{key}`"), value, &range).map(Some)
    }

    /// A number above zero, up to `most`.
    pub(super) fn positive(&mut self, key: &'static str, most: f32) -> Result<Option<f32>, SceneError> {
        self.number(key, SMALLEST..=most)
    }

    /// A whole number.
    pub(super) fn whole(&mut self, key: &'static str, range: RangeInclusive<i64>) -> Result<Option<i64>, SceneError> {
        let Some(item) = self.item(key) else { return Ok(None) };
        let value = item.as_integer().ok_or_else(|| self.wrong_type(key, "a whole number"))?;
        self.whole_within(key, value, &range).map(Some)
    }

    /// A whole number that fits `u32`.
    pub(super) fn count(&mut self, key: &'static str, range: RangeInclusive<u32>) -> Result<Option<u32>, SceneError> {
        let value = self.whole(key, i64::from(*range.start())..=i64::from(*range.end()))?;
        Ok(value.and_then(|v| u32::try_from(v).ok()))
    }

    /// One whole number or three of them.
    pub(super) fn one_or_three(
        &mut self,
        key: &'static str,
        range: RangeInclusive<u32>,
    ) -> Result<Option<OneOrThree>, SceneError> {
        let Some(array) = self.item(key).and_then(Item::as_array) else {
            return Ok(self.count(key, range)?.map(OneOrThree::One));
        };
        let wanted = "a whole number or three of them";
        let mut three = [0; 3];
        if array.len() != 3 {
            return Err(self.wrong_type(key, wanted));
        }
        for (slot, value) in three.iter_mut().zip(array) {
            let value = value.as_integer().ok_or_else(|| self.wrong_type(key, wanted))?;
            let value = self.whole_within(key, value, &(i64::from(*range.start())..=i64::from(*range.end())))?;
            *slot = u32::try_from(value).unwrap_or(*range.end());
        }
        Ok(Some(OneOrThree::Three(three)))
    }

    /// Three numbers.
    pub(super) fn vector(&mut self, key: &'static str, range: RangeInclusive<f32>) -> Result<Option<Vec3>, SceneError> {
        let Some(item) = self.item(key) else { return Ok(None) };
        let wanted = "three numbers, [x, y, z]";
        let array = item.as_array().filter(|a| a.len() == 3).ok_or_else(|| self.wrong_type(key, wanted))?;
        let mut three = [0.0; 3];
        for (slot, value) in three.iter_mut().zip(array) {
            let value = number_of(value).ok_or_else(|| self.wrong_type(key, wanted))?;
            *slot = self.within(key, &format!("a component of `{key}`"), value, &range)?;
        }
        Ok(Some(Vec3::from_array(three)))
    }

    /// A unit vector, from three numbers of any length but nought.
    pub(super) fn direction(&mut self, key: &'static str) -> Result<Option<Vec3>, SceneError> {
        let Some(vector) = self.vector(key, -FARTHEST..=FARTHEST)? else { return Ok(None) };
        let length = vector.length();
        if !length.is_normal() {
            return Err(self.error_at(key, format!("`{key}` points nowhere; give a vector that is not zero")));
        }
        // A unit vector stays as it is, so that a file written and read again says the same.
        Ok(Some(if (length - 1.0).abs() < 1e-6 { vector } else { vector / length }))
    }

    /// `true` or `false`.
    pub(super) fn flag(&mut self, key: &'static str) -> Result<Option<bool>, SceneError> {
        let Some(item) = self.item(key) else { return Ok(None) };
        item.as_bool().map(Some).ok_or_else(|| self.wrong_type(key, "true or false"))
    }

    /// A string that is not empty.
    pub(super) fn string(&mut self, key: &'static str) -> Result<Option<&'a str>, SceneError> {
        let Some(item) = self.item(key) else { return Ok(None) };
        let text = item.as_str().ok_or_else(|| self.wrong_type(key, "a string in quotes"))?;
        if text.trim().is_empty() {
            return Err(self.error_at(key, format!("`{key}` is empty; write its name or leave it out")));
        }
        Ok(Some(text))
    }

    /// An expression in these variables. A complaint points at the character and quotes its line.
    pub(super) fn expression(
        &mut self,
        key: &'static str,
        variables: &[&str],
    ) -> Result<Option<Expression>, SceneError> {
        let Some(text) = self.string(key)? else { return Ok(None) };
        self.parsed(key, self.table.get(key).and_then(Item::span), text, variables).map(Some)
    }

    /// Two values, each a number or an expression without variables: `[0, "2*pi"]`.
    pub(super) fn range(&mut self, key: &'static str) -> Result<Option<[Expression; 2]>, SceneError> {
        let Some(item) = self.item(key) else { return Ok(None) };
        let wrong_type = || self.wrong_type(key, "two values, such as [0, 1] or [0, \"2*pi\"]");
        let array = item.as_array().filter(|a| a.len() == 2).ok_or_else(wrong_type)?;
        let end = |value: &Value| match value.as_str() {
            Some(text) => self.parsed(key, value.span(), text, &[]),
            None => {
                let text = number_of(value).ok_or_else(wrong_type)?.to_string();
                self.parsed(key, value.span(), &text, &[])
            }
        };
        let ends: Vec<Expression> = array.iter().map(end).collect::<Result<_, _>>()?;
        let values: Vec<f64> = ends.iter().map(|e| e.evaluate::<f64>(&[], &mut Vec::new())).collect();
        if !(values.iter().all(|v| v.abs() <= f64::from(FARTHEST)) && values[0] < values[1]) {
            return Err(self.error_at(key, format!("`{key}` does not run from a lesser to a greater number; mend it")));
        }
        Ok(ends.try_into().ok())
    }

    fn parsed(&self, key: &str, span: Span, text: &str, variables: &[&str]) -> Result<Expression, SceneError> {
        Expression::parse(text, variables).map_err(|e| {
            let (before, after) = text.split_at(e.at.min(text.len()));
            let near: String = before.chars().rev().take(QUOTED).collect::<Vec<_>>().into_iter().rev().collect();
            let quoted = format!("{near}→{}", after.chars().take(QUOTED).collect::<String>()).replace('\n', " ");
            let what = format!("in `{key}`, at the arrow in `{quoted}`: {}", e.what);
            let place = span.map(|span| {
                // Past the opening quotes, unless escapes make the text differ from what the file has there.
                let raw = self.text.text.get(span.clone()).unwrap_or("");
                let inner = raw.find(text).filter(|start| *start <= 4).map_or(0, |start| start + e.at);
                span.start + inner..span.end
            });
            self.text.error(&place, what)
        })
    }

    /// A tree of models: `{ difference = ["block", { union = ["hole", "slot"] }] }`.
    pub(super) fn tree(&mut self, key: &'static str) -> Result<Option<Tree>, SceneError> {
        let Some(item) = self.item(key) else { return Ok(None) };
        let table = item.as_table_like().ok_or_else(|| self.wrong_type(key, TREE))?;
        self.node(table, &item.span(), 0).map(Some)
    }

    fn node(&self, table: &dyn TableLike, span: &Span, depth: usize) -> Result<Tree, SceneError> {
        let error = |what: String| self.text.error(span, what);
        let mut entries = table.iter();
        let (Some((word, of)), None) = (entries.next(), entries.next()) else {
            return Err(error(format!("csg is one operation on a list; write {TREE}")));
        };
        let Some(operation) = Operation::from_word(word) else {
            return Err(error(unknown("operation", word, &Operation::words())));
        };
        let Some(of) = of.as_array().filter(|of| of.len() >= 2 && depth < DEEPEST_TREE) else {
            return Err(error(format!(
                "`{word}` takes a list of two models or more, {DEEPEST_TREE} deep; write {TREE}"
            )));
        };
        let operand = |value: &Value| match value {
            Value::String(name) => Ok(Tree::Model(name.value().clone())),
            Value::InlineTable(table) => self.node(table, &value.span(), depth + 1),
            _ => Err(self.text.error(&value.span(), format!("neither a model's name nor a tree; write {TREE}"))),
        };
        Ok(Tree::Node(operation, of.iter().map(operand).collect::<Result<_, _>>()?))
    }

    /// Two of `true` or `false`.
    pub(super) fn two_flags(&mut self, key: &'static str) -> Result<Option<[bool; 2]>, SceneError> {
        let Some(item) = self.item(key) else { return Ok(None) };
        let flags = item.as_array().map(|a| a.iter().filter_map(Value::as_bool).collect::<Vec<_>>());
        let two = flags.and_then(|flags| <[bool; 2]>::try_from(flags).ok());
        two.map(Some).ok_or_else(|| self.wrong_type(key, "two of true or false, [true, false]"))
    }

    /// Two whole numbers.
    pub(super) fn two_counts(
        &mut self,
        key: &'static str,
        range: RangeInclusive<u32>,
    ) -> Result<Option<[u32; 2]>, SceneError> {
        let Some(item) = self.item(key) else { return Ok(None) };
        let whole = item.as_array().map(|a| a.iter().filter_map(Value::as_integer).collect::<Vec<_>>());
        let two = whole.and_then(|whole| <[i64; 2]>::try_from(whole).ok());
        let two = two.ok_or_else(|| self.wrong_type(key, "two whole numbers, [u, v]"))?;
        let within = i64::from(*range.start())..=i64::from(*range.end());
        let mut counts = [0; 2];
        for (count, value) in counts.iter_mut().zip(two) {
            *count = u32::try_from(self.whole_within(key, value, &within)?).unwrap_or(*range.end());
        }
        Ok(Some(counts))
    }

    /// One of the words of a choice.
    pub(super) fn word<T: Words>(&mut self, key: &'static str) -> Result<Option<T>, SceneError> {
        let Some(index) = self.one_of(key, &T::words())? else { return Ok(None) };
        Ok(Some(T::WORDS[index].0))
    }

    /// The index of the word among `words`.
    pub(super) fn one_of(&mut self, key: &'static str, words: &[&str]) -> Result<Option<usize>, SceneError> {
        let Some(word) = self.string(key)? else { return Ok(None) };
        match words.iter().position(|known| *known == word) {
            Some(index) => Ok(Some(index)),
            None => Err(self.error_at(key, unknown(key, word, words))),
        }
    }

    /// Complains where `key` says something that this version does not do. `usable` are the values that change nothing.
    pub(super) fn not_yet(&mut self, key: &'static str, usable: &[&str]) -> Result<(), SceneError> {
        let Some(item) = self.item(key) else { return Ok(()) };
        let value = item.as_value().map(|v| match v {
            Value::String(s) => s.value().clone(),
            other => other.to_string().trim().to_owned(),
        });
        match value {
            Some(value) if usable.contains(&value.as_str()) => Ok(()),
            Some(value) => Err(self.error_at(key, unavailable(key, &value))),
            None => Err(self.wrong_type(key, usable.first().copied().unwrap_or("nothing"))),
        }
    }

    /// A table inside this one.
    pub(super) fn table(&mut self, key: &'static str) -> Result<Option<Section<'a>>, SceneError> {
        let Some(item) = self.item(key) else { return Ok(None) };
        let table = item.as_table_like().ok_or_else(|| self.wrong_type(key, &format!("a table, [{key}]")))?;
        Ok(Some(Section::new(self.text, table, format!("[{key}]"), item.span())))
    }

    /// A list of tables inside this one; `None` where the file has no such key.
    pub(super) fn tables(
        &mut self,
        key: &'static str,
        path: &str,
        most: usize,
    ) -> Result<Option<Vec<Section<'a>>>, SceneError> {
        let Some(item) = self.item(key) else { return Ok(None) };
        let tables: Vec<(&'a dyn TableLike, Span)> = match item {
            Item::ArrayOfTables(array) => array.iter().map(|t| (t as &dyn TableLike, t.span())).collect(),
            Item::Value(Value::Array(array)) if array.iter().all(Value::is_inline_table) => {
                array.iter().filter_map(Value::as_inline_table).map(|t| (t as &dyn TableLike, t.span())).collect()
            }
            _ => return Err(self.wrong_type(key, &format!("tables under [[{path}]]"))),
        };
        if tables.len() > most {
            let (_, span) = &tables[most];
            return Err(self.text.error(span, format!("more than {most} [[{path}]]; leave the rest out")));
        }
        let section = |(i, (table, span))| Section::new(self.text, table, format!("[[{path}]] {i}"), span);
        Ok(Some(tables.into_iter().enumerate().map(section).collect()))
    }

    /// Complains of keys that nothing asked for.
    pub(super) fn finish(self) -> Result<(), SceneError> {
        for (key, item) in self.table.iter() {
            if self.known.contains(&key) {
                continue;
            }
            let span = self.table.key(key).and_then(toml_edit::Key::span).or_else(|| item.span());
            let what = match nearest(key, self.known.iter().copied()) {
                Some(near) => format!("unknown key `{key}` in {}; did you mean `{near}`?", self.name),
                None => format!("unknown key `{key}` in {}; it knows {}", self.name, self.known.join(", ")),
            };
            return Err(self.text.error(&span.or(self.span), what));
        }
        Ok(())
    }

    fn within(&self, key: &str, what: &str, value: f64, range: &RangeInclusive<f32>) -> Result<f32, SceneError> {
        let (low, high) = (*range.start(), *range.end());
        #[expect(clippy::cast_possible_truncation, reason = "what overflows becomes infinite and is out of range")]
        let value = value as f32;
        if range.contains(&value) {
            return Ok(value);
        }
        let remedy = if low == SMALLEST {
            format!("give a number above 0, at most {high}")
        } else {
            format!("give a number from {low} to {high}")
        };
        let shown = if value.abs() < 1e7 { value.to_string() } else { format!("{value:e}") };
        Err(self.error_at(key, format!("{what} is {shown}; {remedy}")))
    }

    fn whole_within(&self, key: &str, value: i64, range: &RangeInclusive<i64>) -> Result<i64, SceneError> {
        if range.contains(&value) {
            return Ok(value);
        }
        let (low, high) = (range.start(), range.end());
        Err(self.error_at(key, format!("`{key}` is {value}; give a whole number from {low} to {high}")))
    }
}

/// One number for all axes or one for each.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum OneOrThree {
    One(u32),
    Three([u32; 3]),
}

/// Characters of an expression that a complaint quotes on each side of the place.
const QUOTED: usize = 24;
/// How a tree is written.
const TREE: &str = "{ difference = [\"block\", \"hole\"] }";
/// How deep trees may be nested.
const DEEPEST_TREE: usize = 32;
/// The smallest length that is taken for more than nothing.
pub(super) const SMALLEST: f32 = 1e-9;
/// The largest coordinate and radiance: beyond it f32 has no digits left for a cell.
pub(super) const FARTHEST: f32 = 1e6;

/// Text for a word that is none of the choices.
pub(super) fn unknown(key: &str, word: &str, words: &[&str]) -> String {
    match nearest(word, words.iter().copied()) {
        Some(near) => format!("unknown {key} `{word}`; did you mean `{near}`? Choose {}", words.join(", ")),
        None => format!("unknown {key} `{word}`; choose {}", words.join(", ")),
    }
}

/// Text for something that the format names but this version does not do.
pub(super) fn unavailable(key: &str, value: &str) -> String {
    format!("{key} = {value} is not available in this version; leave it out")
}

fn number_of(value: &Value) -> Option<f64> {
    #[expect(clippy::cast_precision_loss, reason = "a scene's numbers end as f32")]
    value.as_float().or_else(|| value.as_integer().map(|i| i as f64))
}

fn kind_of(item: &Item) -> &'static str {
    match item {
        Item::None => "nothing",
        Item::Table(_) | Item::Value(Value::InlineTable(_)) => "a table",
        Item::ArrayOfTables(_) => "a list of tables",
        Item::Value(Value::String(_)) => "a string",
        Item::Value(Value::Integer(_)) => "a whole number",
        Item::Value(Value::Float(_)) => "a number",
        Item::Value(Value::Boolean(_)) => "true or false",
        Item::Value(Value::Datetime(_)) => "a date",
        Item::Value(Value::Array(_)) => "a list",
    }
}
