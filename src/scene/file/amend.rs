//! Writes a scene into the text that it was read from: what did not change keeps its layout, its order and its comments.

use super::{parse, write};
use crate::scene::Scene;
use std::path::Path;
use toml_edit::{ArrayOfTables, DocumentMut, Item, Table, TableLike};

/// `text`, changed where it does not say what `scene` says; a text of its own where that can't be done, as for a text
/// that asks for framing. `path` is where the text is to be read back from, `methods` are the names of the voxelizers.
#[must_use]
pub fn amended(text: &str, scene: &Scene, path: &Path, methods: &[&str]) -> String {
    let says = |text: &str| parse(text, path, methods).ok().map(|(read, _)| read);
    let amended = says(text).and_then(|before| {
        let mut document: DocumentMut = text.parse().ok()?;
        merge(document.as_table_mut(), write::document(&before).as_table(), write::document(scene).as_table());
        Some(document.to_string())
    });
    let is_right =
        |text: &String| says(text).is_some_and(|read| Scene { folder: scene.folder.clone(), ..read } == *scene);
    amended.filter(is_right).unwrap_or_else(|| write::to_toml(scene))
}

/// Makes in `text` the changes that lead from `before` to `after`.
fn merge(text: &mut dyn TableLike, before: &dyn TableLike, after: &dyn TableLike) {
    let gone = before.iter().map(|(key, _)| key).filter(|key| !after.contains_key(key));
    for key in after.iter().map(|(key, _)| key).chain(gone) {
        let (old, new) = (before.get(key), after.get(key));
        if old.map(ToString::to_string) == new.map(ToString::to_string) {
            continue;
        }
        match (text.get_mut(key), new) {
            (Some(item), Some(new)) => merge_item(item, old, new),
            (None, Some(new)) => {
                text.insert(key, new.clone());
            }
            (Some(Item::Table(table)), None) => {
                merge(table, old.and_then(Item::as_table_like).unwrap_or(&Table::new()), &Table::new());
            }
            (_, None) => {
                text.remove(key);
            }
        }
    }
}

fn merge_item(item: &mut Item, before: Option<&Item>, after: &Item) {
    let empty = Table::new();
    match (item, after) {
        (Item::ArrayOfTables(tables), Item::ArrayOfTables(after)) => {
            let none = ArrayOfTables::new();
            let before = before.and_then(Item::as_array_of_tables).unwrap_or(&none);
            while tables.len() > after.len() {
                tables.remove(tables.len() - 1);
            }
            for (index, after) in after.iter().enumerate() {
                match tables.get_mut(index) {
                    Some(table) => merge(table, before.get(index).unwrap_or(&empty), after),
                    None => tables.push(after.clone()),
                }
            }
        }
        (Item::Value(value), Item::Value(after)) if !value.is_inline_table() => {
            let decor = value.decor().clone();
            *value = after.clone();
            *value.decor_mut() = decor;
        }
        (item, after) => match (item.as_table_like_mut(), after.as_table_like()) {
            (Some(table), Some(after)) => merge(table, before.and_then(Item::as_table_like).unwrap_or(&empty), after),
            _ => *item = after.clone(),
        },
    }
}
