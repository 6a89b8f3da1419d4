//! `isomend completions` and `isomend man`: shell completions and manual pages.

use assert_cmd::Command;

fn run(arguments: &[&str]) -> (Option<i32>, String, String) {
    let output = Command::cargo_bin("isomend")
        .unwrap()
        .args(arguments)
        .output()
        .unwrap();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    (
        output.status.code(),
        text(output.stdout),
        text(output.stderr),
    )
}

#[test]
fn completions_name_every_command_and_option() {
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let (code, script, said) = run(&["completions", shell]);
        assert_eq!((code, &said[..]), (Some(0), ""));
        for word in [
            "fill",
            "inspect",
            "surface",
            "max-diameter",
            "keep-open",
            "voxel",
            "config",
            "dry-run",
        ] {
            assert!(script.contains(word), "{word} in {shell}");
        }
    }
    let (code, _, said) = run(&["completions", "tcsh"]);
    assert!(code == Some(2) && said.contains("bash"), "{said}");
}

#[test]
fn manual_pages_are_roff_with_all_options() {
    let (code, page, said) = run(&["man"]);
    assert_eq!((code, &said[..]), (Some(0), ""));
    assert!(
        page.contains(".TH isomend 1") && page.contains("isomend\\-fill(1)"),
        "{page}"
    );
    let (code, page, _) = run(&["man", "fill"]);
    assert_eq!(code, Some(0));
    for option in ["\\-\\-max\\-diameter", "\\-\\-keep\\-open", "\\-\\-json"] {
        assert!(page.contains(option), "{option}");
    }
    let (code, _, said) = run(&["man", "fly"]);
    assert!(code == Some(1) && said.contains("'fly'"), "{said}");
}
