//! Thresholds for inner skins (`repair/solid`).

thresholds! {
    /// Thresholds for inner skins (`repair/solid`). Measured on double skins made from unsigned distances, with pinholes of 1.5 to
    /// 2.6 thicknesses.
    SolidTuning {
        /// Cosine. A face is the other side of another if their normals are opposite within this angle (60°).
        parallel: f64 = 0.5,
        /// Fraction of a component's area that has its other side on another component: then both belong to the same body.
        linked: f64 = 0.2,
        /// Faces. Bodies with fewer have no inner skin.
        least_faces: usize = 100,
        /// Fraction of a body's area that must have another side.
        paired: f64 = 0.5,
        /// Thicknesses. Radius of the ball that finds outer faces: it enters no opening narrower than about three thicknesses.
        ball: f64 = 1.5,
        /// Nodes of the lattice in a radius of this ball. With two, an opening must be wider by a thickness to let the ball in.
        radius_nodes: f64 = 3.0,
        /// Nodes of the lattice, at most: 128 MB.
        nodes: usize = 64_000_000,
        /// Thicknesses. Smallest and largest distance between two sides of a skin.
        skin_least: f64 = 0.4,
        skin_most: f64 = 1.6,
        /// Fraction of the remaining area that must have an inner skin behind it. Double skins had 0.7 and more; a torus whose ring
        /// the ball does not enter had a third.
        covered: f64 = 0.4,
        /// Fraction of the thickness by which the distance of parallel skins varies.
        constant: f64 = 0.25,
        /// Fraction of the area of a closed inner skin that is at this constant distance; else it bounds a cavity.
        constant_part: f64 = 0.9,
        /// Diagonals of its bounding box. A closed inner skin farther than this from the outer one bounds a cavity.
        thin: f64 = 0.08,
        /// Thicknesses. Largest radius of a pinhole along its longer side. Two that overlap had up to 2.6.
        opening: f64 = 3.0,
        /// Fraction of an inner skin's area that its pinholes have in all, at most. A bore has a quarter at twice its width.
        caps: f64 = 0.15,
        /// Fraction of an inner skin's area that must have the outer skin on its other side.
        skin_part: f64 = 0.5,
        /// Cosine. Smallest flushness of a pinhole; the mouth of a bottle's neck has 0.
        flush: f64 = 0.25,
        /// Thicknesses. Width of the outer skin round a pinhole whose normal counts.
        beside: f64 = 1.5,
        /// Thicknesses. Largest distance from a ring at which faces belong to a pinhole's neck.
        neck: f64 = 2.0,
        /// Cosine. Faces whose other side is parallel within this angle (25°) belong to no neck.
        neck_parallel: f64 = 0.9,
    }
}
