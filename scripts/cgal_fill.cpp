// Fills all holes of a mesh with CGAL's triangulate_refine_and_fair_hole. scripts/bench_peers.py compiles and runs this program.
//   cgal_fill IN.off OUT.off CONTINUITY
// Prints the seconds of the filling, without reading and writing.
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/border.h>
#include <CGAL/Polygon_mesh_processing/triangulate_hole.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Surface_mesh/IO/OFF.h>
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <iterator>
#include <vector>

namespace pmp = CGAL::Polygon_mesh_processing;
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Mesh = CGAL::Surface_mesh<Kernel::Point_3>;

int main(int argc, char** argv) {
    Mesh mesh;
    std::ifstream in(argc > 3 ? argv[1] : "");
    if (!in || !CGAL::IO::read_OFF(in, mesh)) return 1;
    const auto start = std::chrono::steady_clock::now();
    std::vector<Mesh::Halfedge_index> rims;
    pmp::extract_boundary_cycles(mesh, std::back_inserter(rims));
    for (const auto rim : rims) {
        std::vector<Mesh::Face_index> faces;
        std::vector<Mesh::Vertex_index> vertices;
        pmp::triangulate_refine_and_fair_hole(
            mesh, rim, std::back_inserter(faces), std::back_inserter(vertices),
            pmp::parameters::fairing_continuity(static_cast<unsigned>(std::atoi(argv[3]))));
    }
    const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
    std::ofstream out(argv[2]);
    out.precision(17);
    CGAL::IO::write_OFF(out, mesh);
    std::cout << taken.count() << "\n";
    return out ? 0 : 1;
}
