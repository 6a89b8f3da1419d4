//! Thresholds for the flow of a level set (`flow`): convergence, divergence, combination of steps, time steps.

thresholds! {
    /// Thresholds for the flow of a level set (`flow`): convergence, divergence, combination of steps, time steps.
    FlowTuning {
        /// Steps. After this many, a flow also counts as converged by the root mean square update of its nodes: on noisy data a
        /// few nodes never converge.
        long: usize = 8,
        /// Voxels. A flow whose last update was larger than this has diverged.
        diverged: f64 = 2.0,
        /// Voxels, root mean square. After [`Self::long`] steps a surface with a smaller update has converged if its energy
        /// hardly falls.
        rough_update: f64 = 0.01,
        /// Relative fall of the energy over three steps. Below this the energy hardly falls.
        rough_fall: f64 = 5e-3,
        /// Fraction of the energy. The flow ends if more than this remains after five steps of more than a voxel each.
        idle: f64 = 0.95,
        /// Voxels. If the first step is longer than this, from an energy above [`Self::diverging_energy`] and
        /// [`Self::diverging_density`], the data are inconsistent and the flow ends. Of 295 levels of eleven meshes none with
        /// such a step converged.
        diverging_step: f64 = 4.0,
        /// Energy. Lower bound of the initial energy of inconsistent data.
        diverging_energy: f64 = 2e4,
        /// Energy per unknown. Lower bound of the initial energy of inconsistent data.
        diverging_density: f64 = 4.0,
        /// κ is doubled when steps grow, until it is at least this.
        kappa_limit: f64 = 16.0,
        /// Voxels. The flow ends after three successive steps longer than this.
        running_step: f64 = 5.0,
        /// Voxels. The flow ends after five successive steps longer than this if more than [`Self::idle`] of the energy remains.
        idle_step: f64 = 1.0,
        /// Steps. After this many, the flow may end on a plateau of the energy.
        plateau_steps: usize = 12,
        /// Voxels. A surface with a smaller update is left to converge and does not end on a plateau.
        plateau_update: f64 = 0.02,
        /// Relative change of the energy over five steps. Below this the energy is on a plateau.
        plateau_change: f64 = 2e-3,
        /// Fraction of a step that has to be taken for the flow to count as converged. Steps are halved, so any value between ½
        /// and 1 asks for whole steps; with 1 and more no flow would converge.
        whole_step: f64 = 0.9,
        /// Voxels. κ is raised where steps are longer than this and do not shrink.
        kappa_update: f64 = 0.05,
        /// Ratio of a step to the step four before it. Below this the steps shrink.
        kappa_shrinking: f64 = 0.7,
        /// Voxels across a hole. Finer grids get a κ larger than the given one. On 12 holes of scans 14 left patches 10 % farther
        /// from the true surface, one of them 2.4 times as far; 28 changed less than 1 %.
        kappa_across: f64 = 20.0,
        /// Ratio of the surface energy after redistancing to the surface energy before it. Above this the zero set has changed
        /// its shape.
        surface_jump: f64 = 4.0,
        /// The same ratio for the whole energy, with the eikonal term.
        energy_jump: f64 = 8.0,
        /// Voxels. The matrix of a step is reused until nodes near the surface may have moved this far.
        drift: f64 = 0.1,
        /// Steps. Upper bound of the earlier steps that a step is combined with.
        memory: usize = 2,
        /// Voxels. Steps are combined as long as they move no node near the surface farther than this: longer steps are far from
        /// the linear regime.
        combined_update: f64 = 0.3,
        /// Ratio of a step's update to the update before it. Steps are combined as long as the ratio is below this.
        shrinking: f64 = 0.9,
        /// Voxels⁴. Up to this time step conjugate gradients need no coarse levels: the mass term dominates the smooth modes.
        short: f64 = 1.0,
        /// Powers of two. The coarse levels are rebuilt when the time step has changed by more than this.
        time_step_change: f64 = 2.5,
        /// Voxels. Upper bound of the update of a node within a voxel of the surface in a time step.
        most_update: f64 = 0.25,
        /// Upper bound of the ratio of a time step to the one before.
        step_growth: f64 = 2.0,
        /// Ratio of a time step to the refused one before it.
        step_cut: f64 = 0.3,
        /// Fraction of the time since the start. Upper bound of a time step: waves that decay faster have nearly vanished, so
        /// their error does not matter.
        step_part: f64 = 0.15,
        /// Voxels⁴. The first time step: in it, waves of four voxels lose a tenth of their height.
        first_step: f64 = 0.02,
        /// Refused time steps in a row after which the flow in time ends.
        most_refusals: usize = 8,
        /// Voxels. Upper bound of a node's update in a time step where only the size of removed features matters. At creases and
        /// where sheets touch the speed is unbounded; accurate time steps would be as short as for updates of a fifth of a voxel.
        most_at_once: f64 = 0.5,
        /// Fraction of the whole time that the first step takes in that mode.
        first_part: f64 = 0.05,
        /// Least second derivative of an energy density in the matrix of a step, relative to the second derivative of ½h². With 0
        /// the matrix is singular where a density is linear in h or concave.
        least_second: f64 = 1e-2,
        /// Unknowns. Coarse levels are added until at most this many unknowns remain, which are solved directly.
        few_unknowns: usize = 400,
        /// Free nodes. A lattice with fewer is not coarsened further: its solve starts from the values that it has.
        few_start_unknowns: usize = 400,
    }
}
