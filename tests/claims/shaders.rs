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
