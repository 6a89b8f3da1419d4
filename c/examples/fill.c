/* Fills the hole of a sphere without its top, restores a damaged place and smooths the whole, in memory, and prints
 * what was done.
 *
 *     cc fill.c $(pkg-config --cflags --libs isomend) -lm -o fill && ./fill
 *
 * docs/c.md explains it. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "isomend.h"

enum { RINGS = 18, AROUND = 24 };

/* Ends the program with the message of the call that failed. */
static void check(isomend_status status, const char *what)
{
    if (status != ISOMEND_OK) {
        fprintf(stderr, "%s: %s (status %d)\n", what, isomend_last_error(), (int)status);
        exit(1);
    }
}

/* Prints the progress; 0 lets the work go on. */
static int32_t show(double part, size_t done, size_t all, void *user)
{
    (void)user;
    fprintf(stderr, "%3.0f %%, %zu of %zu regions\n", 100 * part, done, all);
    return 0;
}

/* A sphere of radius 1 without its top: rings of vertices from the bottom up. */
static isomend_mesh *sphere_without_top(void)
{
    static double vertices[3 * (1 + RINGS * AROUND)];
    static uint32_t faces[3 * 2 * RINGS * AROUND];
    const double pi = acos(-1.0);
    size_t corners = 0;
    vertices[2] = -1.0;
    for (uint32_t ring = 0; ring < RINGS; ring++)
        for (uint32_t i = 0; i < AROUND; i++) {
            double latitude = pi * (ring + 1) / 24 - pi / 2, angle = 2 * pi * (i + 0.5 * ring) / AROUND;
            double *vertex = vertices + 3 * (1 + ring * AROUND + i);
            vertex[0] = cos(latitude) * cos(angle);
            vertex[1] = cos(latitude) * sin(angle);
            vertex[2] = sin(latitude);
        }
    for (uint32_t i = 0; i < AROUND; i++) {
        uint32_t next = (i + 1) % AROUND;
        faces[corners++] = 0;
        faces[corners++] = 1 + next;
        faces[corners++] = 1 + i;
        for (uint32_t ring = 0; ring + 1 < RINGS; ring++) {
            uint32_t below = 1 + ring * AROUND, above = below + AROUND;
            uint32_t quad[6] = {below + i, below + next, above + i, below + next, above + next, above + i};
            for (int k = 0; k < 6; k++)
                faces[corners++] = quad[k];
        }
    }
    isomend_mesh *mesh;
    check(isomend_mesh_f64(vertices, 1 + RINGS * AROUND, faces, corners / 3, &mesh), "mesh");
    return mesh;
}

/* Replaces the faces round one vertex of a sphere as if they were damaged, and smooths the sphere; whether it is closed and round. */
static int restored(const double *vertices, size_t vertex_count, const uint32_t *faces, size_t face_count)
{
    isomend_mesh *mesh;
    isomend_result *result;
    check(isomend_mesh_f64(vertices, vertex_count, faces, face_count, &mesh), "mesh");
    uint32_t damaged[AROUND];
    isomend_mask mask = {.faces = damaged, .grow = 0.2};
    for (size_t face = 0; face < face_count && mask.face_count < AROUND; face++)
        for (int k = 0; k < 3; k++)
            if (faces[3 * face + (size_t)k] == 1 + 9 * AROUND)
                damaged[mask.face_count++] = (uint32_t)face;
    check(isomend_restore(mesh, &mask, NULL, NULL, &result), "restore");
    int is_complete = isomend_result_is_complete(result);
    printf("restored round %zu faces; complete: %s\n", mask.face_count, is_complete ? "yes" : "no");
    isomend_result_free(result);

    check(isomend_fair(mesh, NULL, "{\"strength\": 1.2}", NULL, &result), "fair");
    double farthest = 0;
    for (size_t vertex = 0; vertex < isomend_result_vertex_count(result); vertex++) {
        const double *p = isomend_result_vertices(result) + 3 * vertex;
        farthest = fmax(farthest, fabs(sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]) - 1));
    }
    printf("smoothed to %zu faces, at most %.4f from the sphere\n", isomend_result_face_count(result), farthest);
    isomend_result_free(result);
    isomend_mesh_free(mesh);
    return is_complete && farthest < 0.05;
}

int main(void)
{
    if (isomend_abi_version() != ISOMEND_ABI_VERSION) {
        fprintf(stderr, "the library has interface %u, the header %d\n", isomend_abi_version(), ISOMEND_ABI_VERSION);
        return 1;
    }
    isomend_mesh *mesh = sphere_without_top();

    char *report;
    check(isomend_inspect(mesh, NULL, NULL, &report), "inspect");
    printf("%.60s...\n", report);
    isomend_text_free(report);

    isomend_options options = {0};
    options.progress = show;
    isomend_result *result;
    check(isomend_fill(mesh, "{\"max_diameter\": 2, \"unit\": \"mm\"}", &options, &result), "fill");

    size_t vertices = isomend_result_vertex_count(result), faces = isomend_result_face_count(result), patch = 0;
    const double *positions = isomend_result_vertices(result), *errors = isomend_result_expected_errors(result);
    const uint32_t *origins = isomend_result_face_origins(result);
    for (size_t face = 0; face < faces; face++)
        patch += origins[face] == ISOMEND_NEW;
    double farthest = 0, expected = 0;
    for (size_t vertex = 0; vertex < vertices; vertex++) {
        const double *p = positions + 3 * vertex;
        farthest = fmax(farthest, fabs(sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]) - 1));
        expected = fmax(expected, errors[vertex]);
    }
    printf("%zu vertices, %zu faces, %zu of them new; complete: %s\n", vertices, faces, patch,
           isomend_result_is_complete(result) ? "yes" : "no");
    printf("largest distance from the sphere %.4f, largest expected error %.4f\n", farthest, expected);
    int is_good = isomend_result_is_complete(result) && patch > 0 && farthest < 0.02;
    is_good = is_good && restored(positions, vertices, isomend_result_faces(result), faces);

    isomend_result_free(result);
    isomend_mesh_free(mesh);
    return is_good ? 0 : 1;
}
