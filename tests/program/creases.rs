//! Sharp edges (creases) that end at rims, on the command line: lists, remarks, and `--crease`.

use isomend::io::Format;

use crate::desk::{Desk, assert_code, text};
use crate::shapes::{blocked_cube, open_cube};

fn cubes() -> Desk {
    let desk = Desk::new();
    desk.save("cube.ply", &open_cube(), Format::Ply);
    desk.save("blocked.ply", &blocked_cube(), Format::Ply);
    desk
}

#[test]
fn inspect_lists_where_sharp_edges_end() {
    let desk = cubes();
    let table = text(&desk.run(&["inspect", "cube.ply"]).stdout);
    assert!(table.contains(" hole  edges creases "), "{table}");
    assert!(table.contains("5 sharp edges end at the rims of 2 holes (-v lists them)"));
    let listed = text(&desk.run(&["inspect", "cube.ply", "-v"]).stdout);
    let rows = listed.lines().filter(|line| line.contains("90.0°"));
    assert_eq!(rows.count(), 5, "{listed}");
    desk.run(&["inspect", "cube.ply", "--json", "cube.json"]);
    let ends = desk.json("cube.json")["crease_ends"].clone();
    assert_eq!(ends.as_array().unwrap().len(), 5);
    assert_eq!(ends[4]["id"], 5);
    assert!(ends[0]["position"].is_array() && ends[0]["vertex"].is_u64());
    // Smooth shapes have no crease column and no remark.
    let ball = text(&desk.run(&["inspect", "ball.ply", "-v"]).stdout);
    assert!(
        !ball.contains("crease") && !ball.contains("sharp"),
        "{ball}"
    );
}

#[test]
fn pictures_and_pages_mark_crease_ends() {
    let desk = cubes();
    let drawn = ["--report", "cube.html", "--picture", "cube.png"];
    assert_code(
        &desk.run(&[&["inspect", "cube.ply"], &drawn[..]].concat()),
        0,
    );
    let page = std::fs::read_to_string(desk.path("cube.html")).unwrap();
    assert!(page.contains("5 sharp edges end at the rims of 2 holes"));
    let ends = page.split("\"ends\":[[").nth(1).unwrap();
    assert_eq!(ends.split("]]").next().unwrap().matches("],[").count(), 4);
    let decoder = png::Decoder::new(std::io::Cursor::new(
        std::fs::read(desk.path("cube.png")).unwrap(),
    ));
    let mut reader = decoder.read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut bytes).unwrap();
    let red = |rgb: &&[u8]| rgb[0] > 160 && rgb[1] < 60 && rgb[2] < 90;
    assert!(bytes.chunks(3).filter(red).count() > 100);
}

#[test]
fn sharp_edges_that_are_not_continued_get_a_remark() {
    let desk = cubes();
    let fill =
        |more: &[&str]| desk.run(&[&["fill", "blocked.ply", "-o", "out.ply"], more].concat());
    let said = text(&fill(&[]).stderr);
    assert!(said.contains("  edge not continued"), "{said}");
    assert!(
        said.contains(": 2 sharp edges end at its rim and were not continued: ")
            && said.contains("faces of the continued sides intersected others; --crease A+B"),
        "{said}"
    );
    assert!(said.contains("by continued sides"), "{said}");
    assert_code(&fill(&["--strict"]), 3);
    assert_code(&fill(&["--strict", "--sharp", "off"]), 0);
    fill(&["--json", "out.json"]);
    let regions = desk.json("out.json")["regions"].clone();
    let regions = regions.as_array().unwrap();
    let lost = regions
        .iter()
        .find(|r| !r["not_continued"].is_null())
        .unwrap();
    assert_eq!(lost["crease_ends"], 2);
    assert_eq!(lost["not_continued"]["cause"], "intersects");
    let whole = desk.run(&["fill", "cube.ply", "-o", "out.ply", "--strict"]);
    assert_code(&whole, 0);
}

#[test]
fn an_edge_is_chosen_by_the_numbers_of_its_ends() {
    let desk = cubes();
    desk.run(&["inspect", "cube.ply", "--json", "cube.json"]);
    let ends = desk.json("cube.json")["crease_ends"].clone();
    let of_hole = |hole: u64| {
        ends.as_array()
            .unwrap()
            .iter()
            .filter(move |e| e["hole"] == hole)
    };
    let hole = (1..=2).find(|&hole| of_hole(hole).count() == 2).unwrap();
    let pair: Vec<String> = of_hole(hole).map(|end| end["id"].to_string()).collect();
    let pair = pair.join("+");
    let fill = |more: &[&str]| desk.run(&[&["fill", "cube.ply", "-o", "out.ply"], more].concat());
    assert_code(
        &fill(&["--crease", &pair, "--strict", "--json", "out.json"]),
        0,
    );
    let regions = desk.json("out.json")["regions"].clone();
    let region = regions
        .as_array()
        .unwrap()
        .iter()
        .find(|r| r["holes"][0] == hole);
    assert_eq!(region.unwrap()["closed_by"], "sides");
    // The same from an option file.
    let first = std::fs::read(desk.path("out.ply")).unwrap();
    desk.text("options.toml", &format!("[fill]\ncrease = ['{pair}']\n"));
    assert_code(&fill(&["--config", "options.toml"]), 0);
    assert_eq!(std::fs::read(desk.path("out.ply")).unwrap(), first);
    assert_code(&fill(&["--crease", "1+9"]), 1);
    assert!(text(&fill(&["--crease", "1+5"]).stderr).contains("name two ends of one hole"));
    for wrong in ["1", "1+1", "1+2+3", "x+1"] {
        assert_code(&fill(&["--crease", wrong]), 2);
    }
    let smooth = fill(&["--crease", &pair, "--sharp", "off"]);
    assert_code(&smooth, 2);
    assert!(text(&smooth.stderr).contains("not with `--sharp` off"));
}
