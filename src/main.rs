fn main() {
    let a: Vec<String> = std::env::args().collect();
    let l = isomend::io::read_path(a[2].as_ref(), None).unwrap();
    let mut p = isomend::FillParams::default();
    if let Ok(v) = std::env::var("RATIO") {
        p.edge_ratio = v.parse().unwrap();
    }
    if let Ok(v) = std::env::var("VOXEL") {
        p.voxel = isomend::VoxelSize::Length(v.parse().unwrap());
    }
    if std::env::var("WHOLE").is_ok() {
        p.surface = isomend::SurfaceKind::Whole;
    }
    let f = isomend::fill(&l.mesh, &p).unwrap();
    for s in isomend::report::summary_lines(&f.report) {
        eprintln!("{s}");
    }
    for r in &f.report.regions {
        eprintln!("  tries {:?}", r.earlier_tries);
        for l in &r.levels {
            eprintln!("  {:.4} nodes {} U {} steps {} conv {} last {:.1e} its {} {:.2?}", l.voxel, l.nodes, l.flow.unknowns, l.flow.steps.len(), l.flow.converged, l.flow.steps.last().map_or(0.0, |s| s.movement), l.flow.steps.iter().map(|s| s.iterations).sum::<usize>(), l.seconds);
        }
    }
    isomend::io::write_path(a[4].as_ref(), &f.mesh, None, &isomend::io::WriteOptions::default()).unwrap();
}
