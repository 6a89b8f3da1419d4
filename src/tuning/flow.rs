//! Thresholds of the flow of a level set (`flow`): when it is steady, when it is lost, and how its steps are combined.

thresholds! {
    /// Thresholds of the flow of a level set (`flow`): when it is steady, when it is lost, and how its steps are combined.
    FlowTuning {
        /// Steps after which a surface counts as steady by the root mean square movement of its nodes too: on rough data a few
        /// nodes never become steady.
        long: usize = 8,
        /// Voxels. A flow whose last step moved the surface by more than this has diverged.
        diverged: f64 = 2.0,
        /// Voxels, root mean square. After [`Self::long`] steps a surface that moves by less than this is steady if its energy
        /// hardly falls.
        rough_movement: f64 = 0.01,
        /// Relative fall of the energy over three steps below which it hardly falls.
        rough_fall: f64 = 5e-3,
        /// Part of the energy. Five steps of more than a voxel each that leave more than this are useless: the flow ends.
        idle: f64 = 0.95,
        /// Voxels. A first step longer than this, from an energy above [`Self::diverging_energy`] and
        /// [`Self::diverging_density`], ends the flow: the data contradict each other. Of 295 levels of eleven meshes none that
        /// began so became steady.
        diverging_step: f64 = 4.0,
        /// Energy at the start of a flow whose data contradict each other, at least.
        diverging_energy: f64 = 2e4,
        /// The same for each unknown.
        diverging_density: f64 = 4.0,
        /// κ is doubled when steps grow, until it is at least this.
        kappa_limit: f64 = 16.0,
        /// Voxels. Three steps in a row longer than this end the flow.
        running_step: f64 = 5.0,
        /// Voxels. Five steps in a row longer than this end the flow if they leave more than [`Self::idle`] of the energy.
        idle_step: f64 = 1.0,
        /// Steps after which the flow may end on a plateau of the energy.
        plateau_steps: usize = 12,
        /// Voxels. A surface that moves by less than this is left to become steady.
        plateau_movement: f64 = 0.02,
        /// Relative change of the energy over five steps that is a plateau.
        plateau_change: f64 = 2e-3,
        /// Fraction of a step that has to be taken for the surface to count as steady: steps are halved, so that any value between ½ and
        /// 1 asks for whole steps. With 1 and more no flow would converge.
        whole_step: f64 = 0.9,
        /// Voxels. κ is raised where steps are longer than this and do not shrink.
        kappa_movement: f64 = 0.05,
        /// Ratio of a step to that four before below which steps shrink.
        kappa_shrinking: f64 = 0.7,
        /// Voxels across a hole up to which κ is as set; finer grids have a larger one. On 12 holes of scans 14 left patches 10 %
        /// farther from the truth, one of them 2.4 times as far; 28 changed less than 1 %.
        kappa_across: f64 = 20.0,
        /// Ratio of the surface's energy after a redistancing to that before, above which the zero set has changed its shape.
        surface_jump: f64 = 4.0,
        /// The same for the whole energy, with the eikonal term.
        energy_jump: f64 = 8.0,
        /// Voxels. The matrix of a step is used again until nodes near the surface may have moved this far.
        drift: f64 = 0.1,
        /// Earlier steps that a step is combined with, at most.
        memory: usize = 2,
        /// Voxels. Steps are combined as long as they move no node near the surface farther than this: longer ones are far from
        /// linear.
        combined_movement: f64 = 0.3,
        /// Steps are combined as long as each moves the surface by less than this part of the movement of the one before.
        shrinking: f64 = 0.9,
        /// Voxels⁴. Up to this time step conjugate gradients need no coarse levels: inertia holds what is smooth.
        short: f64 = 1.0,
        /// Powers of two by which the time step may change before the coarse levels are made again.
        time_step_change: f64 = 2.5,
        /// Voxels. Upper bound of a node's movement within a voxel of the surface in a step in time.
        most_movement: f64 = 0.25,
        /// Ratio of a step in time to the one before, at most.
        step_growth: f64 = 2.0,
        /// Ratio of a step in time to the refused one before.
        step_cut: f64 = 0.3,
        /// Part of the time since the start that a step takes, at most: waves that decay faster have nearly vanished, so that
        /// their error does not matter.
        step_part: f64 = 0.15,
        /// Voxels⁴. The first step in time: waves of four voxels lose a tenth of their height in it.
        first_step: f64 = 0.02,
        /// Refused steps in a row after which a flow in time ends.
        most_refusals: usize = 8,
        /// Voxels. Upper bound of a node's movement in a step where only the size of removed features matters: at creases and
        /// where sheets touch the speed has no bound, and steps that followed it would be as short as those of a fifth of a voxel
        /// allow.
        most_at_once: f64 = 0.5,
        /// Part of the whole time that the first step takes there.
        first_part: f64 = 0.05,
        /// Least second derivative of a density in the matrix of a step, over that of ½h²: with 0 the matrix is singular where a
        /// density is linear in h or concave.
        least_second: f64 = 1e-2,
        /// Unknowns. Levels are added until at most this many are left, which are solved directly.
        few_unknowns: usize = 400,
        /// Free nodes. A lattice with fewer is not coarsened further: its solve starts from the values that it has.
        few_start_unknowns: usize = 400,
    }
}
