//! Isosurface extraction by marching cubes.
