//! What a person reads first: verdicts in colour, lines that fit the terminal, rounded figures, and the verdict on a page.

use std::process::Output;

use isomend::io::Format;

use crate::desk::{Desk, assert_code, text};
use crate::shapes::sheet;

/// A run in a terminal of a width that has colours.
fn in_colours(desk: &Desk, arguments: &[&str], width: usize) -> Output {
    let mut command = desk.command(arguments);
    command
        .env("CLICOLOR_FORCE", "1")
        .env("COLUMNS", width.to_string())
        .env_remove("NO_COLOR")
        .env("TERM", "xterm");
    command.output().unwrap()
}

/// A text without its styles.
fn plain(text: &str) -> String {
    let mut parts = text.split('\u{1b}');
    let first = parts.next().unwrap_or_default().to_owned();
    let rest = parts.filter_map(|part| part.split_once('m').map(|(_, rest)| rest));
    first + &rest.collect::<String>()
}

#[test]
fn verdicts_have_the_colour_of_their_answer() {
    let [red, yellow, green] = ["\u{1b}[31m", "\u{1b}[33m", "\u{1b}[32m"];
    let desk = Desk::new();
    let no = in_colours(&desk, &["check", "ball.ply"], 80);
    assert_code(&no, 3);
    let said = text(&no.stdout);
    assert!(said.lines().next().unwrap().contains(red), "{said:?}");
    let fill = ["fill", "ball.ply", "-o", "part.ply", "--keep-open", "1"];
    let said = text(&in_colours(&desk, &fill, 80).stderr);
    assert!(
        said.contains(&format!("{yellow}1 of 2 holes closed")),
        "{said:?}"
    );
    let whole = ["repair", "ball.ply", "-o", "whole.ply"];
    let said = text(&in_colours(&desk, &whole, 80).stderr);
    assert!(
        said.contains(&format!("{green}both holes are closed")),
        "{said:?}"
    );
    assert!(
        said.contains(&format!("{green}watertight and printable: yes")),
        "{said:?}"
    );
    let both = in_colours(&desk, &["check", "ball.ply", "whole.ply"], 80);
    let said = text(&both.stdout);
    assert!(
        said.contains(&format!("{red}no:")) && said.contains(&format!("{green}yes")),
        "{said:?}"
    );
}

#[test]
fn what_is_printed_fits_the_terminal() {
    let desk = Desk::new();
    let runs: [&[&str]; 5] = [
        &["inspect", "ball.ply"],
        &["check", "ball.ply"],
        &["fill", "ball.ply", "--dry-run"],
        &["fill", "ball.ply", "-o", "out.ply", "--keep-open", "1"],
        &["compare", "ball.ply", "out.ply", "--samples", "500"],
    ];
    for width in [60, 80, 120] {
        for arguments in runs {
            let done = in_colours(&desk, arguments, width);
            for said in [text(&done.stdout), text(&done.stderr)].map(|said| plain(&said)) {
                let widest = said.lines().map(|line| line.chars().count()).max();
                assert!(widest.unwrap_or(0) <= width, "{width}: {said}");
            }
        }
    }
}

#[test]
fn figures_are_rounded_and_nouns_agree_with_them() {
    let desk = Desk::new();
    let said = text(
        &desk
            .run(&["fill", "ball.ply", "-o", "out.ply", "--keep-open", "1"])
            .stderr,
    );
    assert!(said.contains("new surface: 1 patch, area "), "{said}");
    assert!(said.contains(" % of the whole surface"), "{said}");
    assert!(!said.contains("seam"), "{said}");
    let compared = ["compare", "ball.ply", "out.ply", "--samples", "500"];
    let said = text(&desk.run(&compared).stdout);
    let kept = said
        .lines()
        .find(|line| line.starts_with("A to B"))
        .unwrap();
    let cells: Vec<&str> = kept.split_whitespace().skip(3).collect();
    assert_eq!(cells, ["0", "0", "0", "0°", "0°"], "{said}");
    let line = "kept in B bit for bit: all 590 vertices and all 1124 faces of A, in the same order";
    assert!(said.contains(line), "{said}");
    let said = text(
        &desk
            .run(&["compare", "out.ply", "ball.ply", "--samples", "500"])
            .stdout,
    );
    assert!(said.contains("kept in B bit for bit: 590 of "), "{said}");
    assert!(
        said.contains("(the first 590 with the same numbers)"),
        "{said}"
    );
}

#[test]
fn pages_have_the_verdict_and_lead_to_the_defects() {
    let desk = Desk::new();
    let page = |name: &str| std::fs::read_to_string(desk.path(name)).unwrap();
    desk.run(&["check", "ball.ply", "--report", "check.html"]);
    let check = page("check.html");
    assert!(check.contains("<p class=\"badge bad\" role=\"status\">not printable</p>"));
    assert_eq!(
        check.matches("data-defect=\"").count(),
        2,
        "a button and its selector in the script"
    );
    assert!(
        check.contains("style=\"background:rgb(43,108,196)\""),
        "the blue of boundary edges"
    );
    assert!(check.contains("at 2 places"));
    desk.run(&[
        "fill",
        "ball.ply",
        "-o",
        "out.ply",
        "--keep-open",
        "1",
        "--report",
        "fill.html",
    ]);
    let fill = page("fill.html");
    assert!(fill.contains("<p class=\"badge fair\" role=\"status\">1 of 2 holes left open</p>"));
    assert!(!fill.contains("<ol id=\"faults\">"));
    desk.run(&[
        "repair",
        "ball.ply",
        "-o",
        "whole.ply",
        "--report",
        "repair.html",
    ]);
    assert!(
        page("repair.html")
            .contains("<p class=\"badge good\" role=\"status\">watertight and printable</p>")
    );
}

#[test]
fn check_names_the_command_that_mends() {
    let desk = Desk::new();
    let said = |arguments: &[&str]| plain(&text(&desk.run(arguments).stdout));
    let open = said(&["check", "ball.ply"]);
    assert!(
        open.ends_with("\nto close the holes: isomend fill ball.ply -o OUT\n"),
        "{open}"
    );
    // A fill leaves the border of a sheet open.
    desk.save("sheet.ply", &sheet(6), Format::Ply);
    let open = said(&["check", "sheet.ply"]);
    let command = "isomend repair sheet.ply -o OUT --close-borders";
    assert!(
        open.ends_with(&format!("\nto close the outer border: {command}\n")),
        "{open}"
    );
    assert_code(&desk.run(&["fill", "ball.ply", "-o", "whole.ply"]), 0);
    // A wall that is too thin is no work for a repair.
    for sound in [
        said(&["check", "whole.ply"]),
        said(&["check", "whole.ply", "--min-wall", "100"]),
    ] {
        assert!(!sound.contains("-o OUT"), "{sound}");
    }
}
