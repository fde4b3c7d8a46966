//! `enfilade view` starts another program.

use crate::support::Folder;
use std::process::Command;

#[test]
fn without_the_viewer_it_says_how_to_build_it() {
    let folder = Folder::empty();
    // A copy: the viewer may be beside the original.
    let program = folder.path("enfilade");
    std::fs::copy(env!("CARGO_BIN_EXE_enfilade"), &program).expect("copied");
    let output = Command::new(&program)
        .arg("view")
        .env("PATH", folder.path("nowhere"))
        .output()
        .expect("it starts");
    assert_eq!(output.status.code(), Some(2));
    let error = String::from_utf8(output.stderr).expect("text");
    assert!(error.contains("cargo build --release --manifest-path"), "{error}");
}

#[cfg(unix)]
#[test]
fn it_passes_all_arguments_to_the_viewer_beside_it() {
    use std::os::unix::fs::PermissionsExt;
    let folder = Folder::empty();
    let program = folder.path("enfilade");
    std::fs::copy(env!("CARGO_BIN_EXE_enfilade"), &program).expect("copied");
    let viewer = folder.path("enfilade-viewer");
    folder.add("enfilade-viewer", "#!/bin/sh\necho \"$@\"\nexit 3\n");
    std::fs::set_permissions(&viewer, std::fs::Permissions::from_mode(0o755)).expect("set");
    let output = Command::new(&program)
        .args(["view", "scene.glb", "--freeze", "--eye", "-1,2,3"])
        .output()
        .expect("it starts");
    let said = String::from_utf8(output.stdout).expect("text");
    assert_eq!(said, "scene.glb --freeze --eye -1,2,3\n");
    assert_eq!(output.status.code(), Some(2));
}
