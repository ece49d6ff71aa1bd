//! Changes scene text by path, keeping its layout and comments.

use crate::scene::SceneError;
use toml_edit::{ArrayOfTables, DocumentMut, Item, Key, Table, TableLike, Value};

/// Lists of tables: where the file has none, an index makes one.
const LISTS: &[&str] = &["light", "model", "material", "deformer"];

/// Applies `--set path=value`, such as `effect.max_events=4`, `model.0.material.0.ior=1.3` or `model.fish.scale=2`, to
/// scene text before it is parsed, so that the same checks and messages hold. Items of lists go by index (the next free
/// one adds an item) or by name. What is no TOML value is taken as a string.
///
/// # Errors
/// When the path names no place in the file.
pub fn set(text: &str, assignment: &str) -> Result<String, SceneError> {
    let error = |what: String| SceneError::new(format!("--set {assignment}"), what);
    let (path, value) = assignment
        .split_once('=')
        .ok_or_else(|| error("there is no `=`; write path=value, such as effect.max_events=4".to_owned()))?;
    let keys = Key::parse(path.trim())
        .map_err(|e| error(format!("`{path}` is no path ({}); write names with dots", e.message().trim())))?;
    let Some((last, way)) = keys.split_last() else {
        return Err(error("the path is empty; write path=value".to_owned()));
    };
    let value = value.trim();
    if value.is_empty() {
        return Err(error("the value is empty; write path=value".to_owned()));
    }
    let value = value.parse::<Value>().unwrap_or_else(|_| Value::from(value));

    let mut document: DocumentMut = text.parse().map_err(|e: toml_edit::TomlError| {
        error(format!("the scene itself is no TOML ({}); mend it first", e.message().trim()))
    })?;
    let mut place = Place::Table(document.as_table_mut());
    for key in way {
        place = place.enter(key.get()).map_err(error)?;
    }
    place.put(last.get(), value).map_err(error)?;
    Ok(document.to_string())
}

/// Where a path has led so far.
enum Place<'d> {
    Table(&'d mut dyn TableLike),
    Tables(&'d mut ArrayOfTables),
    Values(&'d mut toml_edit::Array),
}

impl<'d> Place<'d> {
    fn enter(self, key: &str) -> Result<Self, String> {
        match self {
            Self::Table(table) => {
                let item = table.entry(key).or_insert_with(|| {
                    if LISTS.contains(&key) {
                        Item::ArrayOfTables(ArrayOfTables::new())
                    } else {
                        Item::Table(Table::new())
                    }
                });
                Self::of(item).ok_or_else(|| format!("`{key}` holds a plain value, nothing inside it can be set"))
            }
            Self::Tables(tables) => {
                let names = tables.iter().map(|t| name_of(t).map(str::to_owned)).collect::<Vec<_>>();
                let index = index_of(key, &names, true)?;
                if index == tables.len() {
                    tables.push(Table::new());
                }
                let table = tables.get_mut(index).ok_or_else(|| format!("there is no item {index}"))?;
                Ok(Self::Table(table))
            }
            Self::Values(values) => {
                let names: Vec<_> =
                    values.iter().map(|v| v.as_inline_table().and_then(|t| name_of(t).map(str::to_owned))).collect();
                let index = index_of(key, &names, false)?;
                match values.get_mut(index) {
                    Some(Value::InlineTable(table)) => Ok(Self::Table(table)),
                    Some(Value::Array(array)) => Ok(Self::Values(array)),
                    _ => Err(format!("item {index} holds a plain value, nothing inside it can be set")),
                }
            }
        }
    }

    fn of(item: &'d mut Item) -> Option<Self> {
        match item {
            Item::Table(table) => Some(Self::Table(table)),
            Item::ArrayOfTables(tables) => Some(Self::Tables(tables)),
            Item::Value(Value::InlineTable(table)) => Some(Self::Table(table)),
            Item::Value(Value::Array(array)) => Some(Self::Values(array)),
            _ => None,
        }
    }

    fn put(self, key: &str, value: Value) -> Result<(), String> {
        match self {
            Self::Table(table) => {
                if matches!(table.get(key), Some(Item::Table(_) | Item::ArrayOfTables(_))) {
                    return Err(format!("`{key}` is a table; set one of its keys, such as {key}.name=value"));
                }
                table.insert(key, Item::Value(value));
                Ok(())
            }
            Self::Tables(_) => Err(format!("`{key}` is an item of a list; set one of its keys")),
            Self::Values(values) => {
                let index = index_of(key, &vec![None; values.len()], false)?;
                values.replace(index, value);
                Ok(())
            }
        }
    }
}

/// What a table of a list is called: its `name` (models), its `part` (materials) or its `kind`.
fn name_of(table: &dyn TableLike) -> Option<&str> {
    ["name", "part", "kind"].into_iter().find_map(|key| table.get(key).and_then(Item::as_str))
}

fn index_of(key: &str, names: &[Option<String>], may_grow: bool) -> Result<usize, String> {
    if let Some(index) = names.iter().position(|name| name.as_deref() == Some(key)) {
        return Ok(index);
    }
    let most = if may_grow { names.len() } else { names.len().saturating_sub(1) };
    match key.parse::<usize>() {
        Ok(index) if index <= most && (may_grow || !names.is_empty()) => Ok(index),
        Ok(index) => Err(format!("there is no item {index}; the list has {}", names.len())),
        Err(_) => {
            let known: Vec<&str> = names.iter().flatten().map(String::as_str).collect();
            Err(match known.as_slice() {
                [] => format!("`{key}` is no index into a list of {}; count from 0", names.len()),
                _ => format!("`{key}` names no item; choose {} or an index from 0", known.join(", ")),
            })
        }
    }
}
