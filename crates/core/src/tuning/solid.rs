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
        /// Fraction of a body's area in front of which there must be another part of the body: in front of an inner skin there is
        /// always one. Bounds the time for bodies without inner skins.
        faced: f64 = 0.25,
        /// Nodes of the lattice, at most: 128 MB.
        nodes: usize = 64_000_000,
        /// Nodes of the lattice for each face, at most, beside the first million: it bounds the time, half a microsecond each.
        /// Double skins as they come from marching cubes have 4.
        face_nodes: usize = 100,
        /// Thicknesses. Smallest and largest distance between two sides of a skin.
        skin_least: f64 = 0.4,
        skin_most: f64 = 1.6,
        /// Fraction of the remaining area that must have an inner skin behind it. Double skins had 0.7 and more; a torus whose ring
        /// the ball does not enter had a third.
        covered: f64 = 0.4,
        /// Fraction of the thickness by which the distance of parallel skins varies.
        constant: f64 = 0.25,
        /// Fraction of the area of a closed inner skin that is at this constant distance; else it bounds a cavity.
        constant_part: f64 = 0.7,
        /// Diagonals of the body's bounding box. A closed inner skin farther than this from the outer one bounds a cavity.
        thin: f64 = 0.08,
        /// Diagonals of the bounding box. With pinholes: the same. Double skins had up to 0.065.
        thin_pierced: f64 = 0.12,
        /// Thicknesses. Largest radius of a pinhole along its longer side. Two that overlap had up to 2.6.
        opening: f64 = 3.0,
        /// Fraction of an inner skin's area that its pinholes have in all, at most. A bore has a quarter at twice its width.
        caps: f64 = 0.15,
        /// Fraction of an inner skin's area that must have the outer skin on its other side at a constant distance.
        skin_part: f64 = 0.5,
        /// Cosine. The outer skin is a tube along the axis of an opening where its normals are perpendicular to the axis within this
        /// (20°).
        tube: f64 = 0.35,
        /// Fraction of the outer skin's area round an opening that is such a tube at a mouth.
        tube_part: f64 = 0.7,
        /// The smaller over the larger second moment of the normals across the axis: one for a round tube, zero for the two sides of
        /// a thin edge. A mouth has at least this.
        round: f64 = 0.3,
        /// Thicknesses. Width of the outer skin round an opening whose normals count.
        beside: f64 = 1.5,
        /// Thicknesses. Largest distance from a ring at which faces belong to a pinhole's neck: the lip round it is half a circle of the
        /// diameter of one thickness, so that it ends at 0.7.
        neck: f64 = 1.4,
        /// Cosine. Faces whose other side is parallel within this angle (14°) and at the thickness within this fraction belong to
        /// no neck.
        neck_parallel: f64 = 0.97,
        neck_constant: f64 = 0.1,
        /// Rings of faces beside a neck that are removed with it. With two, small bodies lost up to 4.3 % of the outer skin.
        neck_rings: usize = 1,
    }
}
