//! Every shader resolves, parses and validates.

use murrine::gpu::shader::ShaderLibrary;

#[test]
fn every_shader_validates() {
    let library = ShaderLibrary::default();
    let names = library.names().unwrap();
    let mains: Vec<_> = names.iter().filter(|n| !n.ends_with(".inc.wgsl")).collect();
    let faults: Vec<String> = mains.iter().filter_map(|n| library.load(n).err()).map(|e| e.to_string()).collect();
    assert!(!names.is_empty(), "no shaders were embedded");
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn a_broken_shader_is_found_at_its_line_before_the_old_ones_go() {
    let folder = tempfile::tempdir().unwrap();
    for name in ShaderLibrary::default().names().unwrap() {
        let to = folder.path().join(&name);
        std::fs::create_dir_all(to.parent().unwrap()).unwrap();
        std::fs::copy(std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("shaders").join(&name), to).unwrap();
    }
    let library = ShaderLibrary::Folder(folder.path().to_owned());
    library.check_all().unwrap();
    let shade = folder.path().join("shade.wgsl");
    let text = std::fs::read_to_string(&shade).unwrap();
    let line = text.lines().position(|l| l.starts_with("fn has_path(")).unwrap() + 1;
    std::fs::write(&shade, text.replace("fn has_path(", "fn has_path!(")).unwrap();
    let error = library.check_all().unwrap_err().to_string();
    assert!(error.starts_with(&format!("shaders/shade.wgsl:{line}:")), "{error}");
}
