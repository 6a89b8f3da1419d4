//! Volumes in projects of SuperSlicer and Slic3r: ranges of triangles, which stay true when triangles are added.

use glam::DVec3;

use crate::desk::{Desk, assert_code, text};
use crate::packages::{VOLUMES, holed, prusa, repacked, unpacked};
use crate::projects::{part, ranges, triangles};

#[test]
fn volumes_follow_their_triangles_in_the_files_of_superslicer() {
    let desk = Desk::new();
    let volumes = [
        ("ball", holed(5.0, DVec3::ZERO)),
        ("knob", holed(2.0, DVec3::new(9.0, 0.0, 0.0))),
    ];
    prusa(&desk, "prusa.3mf", &volumes, false);
    let prusa = unpacked(&desk, "prusa.3mf");
    let own = "Metadata/SuperSlicer_model.config";
    // SuperSlicer writes its own file, or besides it the file of PrusaSlicer.
    for with_both in [false, true] {
        let mut parts = prusa.clone();
        let config = parts[VOLUMES].clone();
        parts.insert(own.to_owned(), config);
        if !with_both {
            parts.remove(VOLUMES);
        }
        repacked(&desk, "in.3mf", &parts);
        let done = desk.run(&["fill", "in.3mf", "-o", "out.3mf"]);
        assert_code(&done, 0);
        let model = part(&desk, "out.3mf", "3D/3dmodel.model");
        let all = triangles(&model, 1).len();
        let knob = triangles(&part(&desk, "in.3mf", "3D/3dmodel.model"), 1);
        let knob = &knob[volumes[0].1.faces.len()];
        let start = triangles(&model, 1).iter().position(|t| t == knob).unwrap();
        for name in [own, VOLUMES].iter().take(1 + usize::from(with_both)) {
            let ranges = ranges(&part(&desk, "out.3mf", name));
            assert_eq!(ranges, [[0, start - 1], [start, all - 1]], "{name}");
        }
    }
}

#[test]
fn volumes_in_the_mesh_of_slic3r_follow_their_triangles() {
    let desk = Desk::new();
    let volumes = [
        ("ball", holed(5.0, DVec3::ZERO)),
        ("knob", holed(2.0, DVec3::new(9.0, 0.0, 0.0))),
    ];
    let sizes = volumes.clone().map(|(_, mesh)| mesh.faces.len());
    prusa(&desk, "prusa.3mf", &volumes, false);
    let mut parts = unpacked(&desk, "prusa.3mf");
    parts.remove(VOLUMES);
    let lists = |all: &[[usize; 2]]| {
        let volume = |[from, to]: &[usize; 2]| {
            format!(
                "<slic3r:volume ts=\"{from}\" te=\"{to}\" modifier=\"0\" >\n<slic3r:metadata type=\"slic3r.fill_density\">20%</slic3r:metadata>\n</slic3r:volume>\n"
            )
        };
        let volumes: String = all.iter().map(volume).collect();
        format!("<slic3r:volumes>\n{volumes}</slic3r:volumes>\n")
    };
    let space = "2017/06\" xmlns:slic3r=\"http://slic3r.org/3mf/2018/01\"";
    let plain = text(&parts["3D/3dmodel.model"]).replacen("2017/06\"", space, 1);
    let split = [[0, sizes[0] - 1], [sizes[0], sizes[0] + sizes[1] - 1]];
    let whole = [[0, split[1][1]]];
    for list in [&split[..], &whole[..]] {
        let model = plain.replacen("   </mesh>", &format!("{}   </mesh>", lists(list)), 1);
        parts.insert("3D/3dmodel.model".to_owned(), model.clone().into_bytes());
        repacked(&desk, "in.3mf", &parts);
        let done = desk.run(&["fill", "in.3mf", "-o", "out.3mf"]);
        assert_code(&done, 0);
        let after = part(&desk, "out.3mf", "3D/3dmodel.model");
        let [before, new] = [&model, &after].map(|model| triangles(model, 1));
        assert!(new.len() > before.len() + 20);
        let start = new.iter().position(|t| *t == before[sizes[0]]).unwrap();
        let wanted = match list.len() {
            1 => vec![[0, new.len() - 1]],
            _ => vec![[0, start - 1], [start, new.len() - 1]],
        };
        assert!(after.contains(&lists(&wanted)), "{wanted:?}");
        assert!(!text(&done.stderr).contains("left out"));
    }
}
