//! Constructive solid geometry: bodies that are the union, intersection or difference of other models of the scene.
//!
//! Source: [`papers::DONG_2004`](crate::papers::DONG_2004), §5.2: "The nodes are first voxelized into respective
//! worksheets. Then the constructions are done from bottom to top". Here is what a scene says of them; what becomes of
//! their voxels is [`crate::csg`].

use super::SceneError;
use super::description::{Bounds, Scene, Source};
use super::geometry::Geometry;
use super::world::World;
use std::collections::HashMap;

/// A tree of models.
#[derive(Debug, Clone, PartialEq)]
pub enum Tree {
    /// The model of this name.
    Model(String),
    /// What an operation makes of at least two.
    Node(Operation, Vec<Tree>),
}

/// What is made of two solids.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Operation {
    /// In one or the other.
    Union,
    /// In both.
    Intersection,
    /// In the first and not in the others.
    Difference,
}

/// The most models that the bodies of a scene are made of, all together: a bit each.
pub const MAX_OPERANDS: usize = 32;

/// A step of a body's program: operands are pushed, operations take two and push one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Step {
    /// Pushes an operand, by its number.
    Operand(u32),
    /// Takes the last two.
    Combine(Operation),
    /// The body is what is left.
    End,
}

/// All bodies of a world.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Bodies {
    /// Body after body.
    pub steps: Vec<Step>,
    /// The operands.
    pub operands: Vec<Operand>,
}

/// A model that a body is made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Operand {
    /// Its index.
    pub model: usize,
    /// The index of the model that is the body.
    pub body: usize,
    /// What is outside of it is inside the body: it is taken away.
    pub turned: bool,
}

impl Tree {
    /// The names of its models, in order.
    #[must_use]
    pub fn names(&self) -> Vec<&str> {
        match self {
            Self::Model(name) => vec![name],
            Self::Node(_, of) => of.iter().flat_map(Self::names).collect(),
        }
    }
}

impl Bodies {
    /// The bodies of a scene whose models are these, in order.
    ///
    /// # Errors
    /// A name that no model has, a model that is used twice, has no triangles or is open.
    pub fn of(scene: &Scene, models: &[std::sync::Arc<Geometry>]) -> Result<Self, SceneError> {
        let mut bodies = Self::default();
        for (body, model) in scene.models.iter().enumerate() {
            if let Source::Csg(tree) = &model.source {
                bodies.push(tree, false, body, (scene, models))?;
                bodies.steps.push(Step::End);
            }
        }
        Ok(bodies)
    }

    fn push(
        &mut self,
        tree: &Tree,
        turned: bool,
        body: usize,
        (scene, models): (&Scene, &[std::sync::Arc<Geometry>]),
    ) -> Result<(), SceneError> {
        let (operation, of) = match tree {
            Tree::Model(name) => return self.push_operand(name, turned, body, (scene, models)),
            Tree::Node(operation, of) => (*operation, of),
        };
        for (i, operand) in of.iter().enumerate() {
            let taken_away = operation == Operation::Difference && i > 0;
            self.push(operand, turned != taken_away, body, (scene, models))?;
            if i > 0 {
                self.steps.push(Step::Combine(operation));
            }
        }
        Ok(())
    }

    fn push_operand(
        &mut self,
        name: &str,
        turned: bool,
        body: usize,
        (scene, models): (&Scene, &[std::sync::Arc<Geometry>]),
    ) -> Result<(), SceneError> {
        let error = |what: String| SceneError::new(format!("model `{}`", scene.models[body].name), what);
        let Some(model) = scene.models.iter().position(|m| m.name == name) else {
            let known: Vec<&str> = scene.models.iter().map(|m| m.name.as_str()).collect();
            return Err(error(format!("its csg names `{name}`, which is no model; choose {}", known.join(", "))));
        };
        if matches!(scene.models[model].source, Source::Csg(_)) {
            let what = format!("its csg names `{name}`, which has one itself; write that one's tree in its place");
            return Err(error(what));
        }
        if self.operands.iter().any(|o| o.model == model) {
            return Err(error(format!("its csg names `{name}` a second time; add a second model like it")));
        }
        let open = models.get(model).map_or(0, |geometry| open_edges(geometry));
        if open > 0 {
            let what = format!(
                "its csg names `{name}`, whose mesh is open at {open} edges; only closed ones have an inside: close it"
            );
            return Err(error(what));
        }
        if models.get(model).is_none_or(|g| g.triangles.is_empty() && g.made_from.is_none()) {
            return Err(error(format!("its csg names `{name}`, which has no triangles; name a closed body")));
        }
        if self.operands.len() == MAX_OPERANDS {
            return Err(error(format!("more than {MAX_OPERANDS} models are named by csg; leave the rest out")));
        }
        self.steps.push(Step::Operand(u32::try_from(self.operands.len()).unwrap_or(u32::MAX)));
        self.operands.push(Operand { model, body, turned });
        Ok(())
    }

    /// The models that are bodies, in order.
    pub fn models(&self) -> impl Iterator<Item = usize> {
        let mut models: Vec<usize> = self.operands.iter().map(|o| o.body).collect();
        models.dedup();
        models.into_iter()
    }

    /// The body that a model is, without the others; operands keep their numbers.
    #[must_use]
    pub fn alone(&self, model: usize) -> Option<Self> {
        let of_model = |steps: &&[Step]| match steps.first() {
            Some(Step::Operand(number)) => self.operands[*number as usize].body == model,
            _ => false,
        };
        let steps = self.steps.split_inclusive(|step| *step == Step::End).find(of_model)?.to_vec();
        Some(Self { steps, operands: self.operands.clone() })
    }

    /// The operand that a model is.
    #[must_use]
    pub fn operand(&self, model: usize) -> Option<(usize, Operand)> {
        self.operands.iter().copied().enumerate().find(|(_, o)| o.model == model)
    }

    /// Works the bodies out on anything that has the three operations, in the bodies' order.
    pub fn evaluate<T: Copy>(&self, operand: impl Fn(usize) -> T, combine: impl Fn(Operation, T, T) -> T) -> Vec<T> {
        let (mut stack, mut done) = (Vec::new(), Vec::new());
        for step in &self.steps {
            match *step {
                Step::Operand(number) => stack.push(operand(number as usize)),
                Step::Combine(operation) => {
                    if let (Some(b), Some(a)) = (stack.pop(), stack.pop()) {
                        stack.push(combine(operation, a, b));
                    }
                }
                Step::End => done.extend(stack.pop()),
            }
        }
        done
    }

    /// The bounds of each body, from those of its operands.
    #[must_use]
    pub fn bounds(&self, operand: impl Fn(usize) -> Bounds) -> Vec<Bounds> {
        self.evaluate(operand, |operation, a, b| match operation {
            Operation::Union => a.union(b),
            Operation::Intersection => Bounds { min: a.min.max(b.min), max: a.max.min(b.max) },
            Operation::Difference => a,
        })
    }
}

impl World {
    /// Whether a model is only there for others to be made of it.
    #[must_use]
    pub fn is_operand(&self, model: usize) -> bool {
        self.bodies.operand(model).is_some()
    }
}

/// How many directed edges of a mesh lack their opposite, vertices told apart by their places.
fn open_edges(geometry: &Geometry) -> usize {
    let key = |v: u32| geometry.vertices[v as usize].position.to_array().map(|x| (x + 0.0).to_bits());
    let mut balance: HashMap<_, i64> = HashMap::new();
    for &[a, b, c] in &geometry.triangles {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            let (from, to) = (key(from), key(to));
            if from < to {
                *balance.entry((from, to)).or_default() += 1;
            } else if to < from {
                *balance.entry((to, from)).or_default() -= 1;
            }
        }
    }
    // Meshes wound both ways round are closed all the same.
    balance.values().filter(|n| **n % 2 != 0).count()
}
