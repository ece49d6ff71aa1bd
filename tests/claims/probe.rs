//! Runs a few lines of WGSL against the program's own shader library and reads what they answer.

use crate::gpu;
use bytemuck::Pod;
use murrine::gpu::shader::ShaderLibrary;
use murrine::gpu::{ComputePass, Layout, Recorder, Timing, buffer};

/// Compiles `source`, entry point `main`, whose includes are those of `shaders/`.
pub(crate) fn compile(source: &str, layouts: &[Layout]) -> ComputePass {
    let folder = tempfile::tempdir().unwrap();
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("shaders");
    std::fs::create_dir(folder.path().join("lib")).unwrap();
    for file in std::fs::read_dir(root.join("lib")).unwrap() {
        let file = file.unwrap();
        std::fs::copy(file.path(), folder.path().join("lib").join(file.file_name())).unwrap();
    }
    std::fs::write(folder.path().join("probe.wgsl"), source).unwrap();
    let own = gpu().with_shaders(ShaderLibrary::Folder(folder.path().to_owned()));
    ComputePass::new(&own, "probe.wgsl", "main", layouts).unwrap_or_else(|e| panic!("{e}"))
}

/// Runs one thread for each of `questions` (bound as `questions`) and reads as many `answers`.
pub(crate) fn ask<Q: Pod, A: Pod>(
    pass: &ComputePass,
    bound: &[(&str, wgpu::BindingResource<'_>)],
    questions: &[Q],
) -> Vec<A> {
    let gpu = gpu();
    let asked = buffer::storage_with(gpu, "questions", questions).unwrap();
    let answers = buffer::storage(gpu, "answers", (questions.len() * size_of::<A>()) as u64).unwrap();
    let mut resources = bound.to_vec();
    resources.push(("questions", asked.as_entire_binding()));
    resources.push(("answers", answers.as_entire_binding()));
    let mut recorder = Recorder::new(gpu, Timing::Off);
    let group = pass.bind(gpu, &resources);
    pass.dispatch(&mut recorder.encoder, &group, [u32::try_from(questions.len()).unwrap(), 1, 1]);
    recorder.finish().unwrap();
    buffer::read(gpu, &answers, 0, questions.len()).unwrap()
}
