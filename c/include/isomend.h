/* isomend: fills holes in triangle meshes, repairs, restores, fairs, checks and inspects them, in memory.
 *
 * The manual is docs/c.md. A test (tests/house/header.rs) compares this file with the source: names, types and values.
 *
 * Every function may be called from any thread. A mesh may be used by several calls at once; a result belongs to one thread at a
 * time. Functions that return a status set their results only if it is ISOMEND_OK; else isomend_last_error has the reason. A pointer to a
 * result must not be null unless its function allows that. */
#ifndef ISOMEND_H
#define ISOMEND_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The version of this interface. A library of another version (isomend_abi_version) must not be used with this header. */
#define ISOMEND_ABI_VERSION 1

/* The origin of a new vertex or face. */
#define ISOMEND_NEW UINT32_MAX

/* How a call ended. */
typedef enum isomend_status {
    /* It did what it was asked for. */
    ISOMEND_OK = 0,
    /* The caller stopped it. */
    ISOMEND_CANCELLED = 1,
    /* A pointer is null or misaligned, or a buffer is too small. */
    ISOMEND_ARGUMENT = 2,
    /* A parameter does not exist, has a wrong value, or does not fit the mesh. */
    ISOMEND_PARAMETER = 3,
    /* The mesh is invalid: a face refers to a missing vertex, a coordinate is not finite, there is no face. */
    ISOMEND_MESH = 4,
    /* A file that a parameter names cannot be read. */
    ISOMEND_FILE = 5,
    /* A fault of isomend; please report it. */
    ISOMEND_INTERNAL = 6
} isomend_status;

/* A mesh. */
typedef struct isomend_mesh isomend_mesh;
/* The result of a fill, a repair, a restoration or a fairing. */
typedef struct isomend_result isomend_result;
/* What stops calls, from any thread. */
typedef struct isomend_cancel isomend_cancel;

/* Receives the progress of a call in the thread that made the call, at most every 5 ms: the part done from 0 to 1, regions done, all
 * regions, and the pointer of the options. Another answer than 0 stops the call. It must return normally: no exception, no longjmp. */
typedef int32_t (*isomend_progress)(double part, size_t done, size_t all, void *user);

/* How a call runs. A null pointer in place of the options stands for all zeros. */
typedef struct isomend_options {
    /* Number of threads; 0 for one per core. The result does not depend on it. */
    uint32_t threads;
    /* The function for the progress; may be null. */
    isomend_progress progress;
    /* Passed to the function. */
    void *user;
    /* What stops the call; may be null. */
    const isomend_cancel *cancel;
} isomend_options;

/* The faces that a restoration replaces and a fairing smooths: their numbers, or vertices. Set what is not used to zero. */
typedef struct isomend_mask {
    /* Numbers of faces, from 0; may be null if there are none. */
    const uint32_t *faces;
    size_t face_count;
    /* Numbers of vertices, from 0: a face is marked if its three vertices are among them. May be null if there are none. */
    const uint32_t *vertices;
    size_t vertex_count;
    /* The marked region grows by the first length along the edges, then shrinks by the second, in the mesh's units; 0 for none. */
    double grow;
    double shrink;
} isomend_mask;

/* The version of the interface that the library has. */
uint32_t isomend_abi_version(void);
/* The version of isomend, such as "0.1.0". */
const char *isomend_version(void);
/* The message of the last call of this thread that failed, in UTF-8; valid until the next call that fails. */
const char *isomend_last_error(void);

/* Makes a mesh: 3 * vertex_count coordinates, 3 * face_count indices of vertices, from 0. The arrays are copied. */
isomend_status isomend_mesh_f64(const double *vertices, size_t vertex_count, const uint32_t *faces, size_t face_count, isomend_mesh **mesh);
/* The same from 32-bit coordinates. */
isomend_status isomend_mesh_f32(const float *vertices, size_t vertex_count, const uint32_t *faces, size_t face_count, isomend_mesh **mesh);
/* Frees a mesh that no call uses. */
void isomend_mesh_free(isomend_mesh *mesh);

/* Fills the holes of a mesh. The parameters are a JSON object, such as {"max_diameter": 20}; null for the defaults. Names and meanings
 * are those in the tables of docs/options.md, as Python has them: isomend_parameters gives the schema. */
isomend_status isomend_fill(const isomend_mesh *mesh, const char *parameters, const isomend_options *options, isomend_result **result);
/* Repairs the defects of a mesh and fills its holes. */
isomend_status isomend_repair(const isomend_mesh *mesh, const char *parameters, const isomend_options *options, isomend_result **result);
/* Cuts the marked faces out of a mesh and fills their holes; all other faces stay. The mask must not be null. */
isomend_status isomend_restore(const isomend_mesh *mesh, const isomend_mask *mask, const char *parameters, const isomend_options *options, isomend_result **result);
/* Smooths the marked faces of a mesh by Willmore flow, or the whole surface if the mask is null, whose faces then are all new. */
isomend_status isomend_fair(const isomend_mesh *mesh, const isomend_mask *mask, const char *parameters, const isomend_options *options, isomend_result **result);
/* Checks a mesh for defects. is_sound (may be null) is set to the answer, report (may be null) to the report as JSON, which
 * isomend_text_free frees. */
isomend_status isomend_check(const isomend_mesh *mesh, const char *parameters, const isomend_options *options, bool *is_sound, char **report);
/* Lists components, holes and defects: report is set to them as JSON, which isomend_text_free frees. */
isomend_status isomend_inspect(const isomend_mesh *mesh, const char *parameters, const isomend_options *options, char **report);
/* Sets schema to the JSON schema of the parameters of "fill", "repair", "restore", "fair" or "check", which isomend_text_free frees. */
isomend_status isomend_parameters(const char *command, char **schema);
/* Frees a text. */
void isomend_text_free(char *text);

/* The number of vertices; the kept vertices of the input are the first, in their order. */
size_t isomend_result_vertex_count(const isomend_result *result);
/* The number of faces; the kept faces of the input are the first, in their order. */
size_t isomend_result_face_count(const isomend_result *result);
/* Three coordinates for each vertex. This and the following arrays are valid until the result is freed. */
const double *isomend_result_vertices(const isomend_result *result);
/* Writes three coordinates for each vertex, rounded to 32 bits, into an array of `capacity` elements. */
isomend_status isomend_result_vertices_f32(const isomend_result *result, float *vertices, size_t capacity);
/* Three vertices for each face. */
const uint32_t *isomend_result_faces(const isomend_result *result);
/* For each vertex its expected error in the mesh's units: 0 for vertices of the input, NaN where there is no estimate. */
const double *isomend_result_expected_errors(const isomend_result *result);
/* For each vertex its number in the input, or ISOMEND_NEW. */
const uint32_t *isomend_result_vertex_origins(const isomend_result *result);
/* For each face the face of the input that it is or was made from (flipped, or with separated corners), or ISOMEND_NEW. */
const uint32_t *isomend_result_face_origins(const isomend_result *result);
/* Whether every hole that was to be filled is closed and, after a repair, the mesh is sound. */
bool isomend_result_is_complete(const isomend_result *result);
/* Whether it is complete without reservation, as --strict of the command line demands it. */
bool isomend_result_is_flawless(const isomend_result *result);
/* The report as JSON: see docs/json.md. */
const char *isomend_result_report(const isomend_result *result);
/* Frees a result and its arrays. */
void isomend_result_free(isomend_result *result);

/* A new token. Calls that have it in their options stop once it is set. */
isomend_cancel *isomend_cancel_new(void);
/* Sets a token, from any thread: calls that have it return ISOMEND_CANCELLED within 50 ms. A token cannot be reset. */
void isomend_cancel_set(const isomend_cancel *cancel);
/* Frees a token that no call uses. */
void isomend_cancel_free(isomend_cancel *cancel);

#ifdef __cplusplus
}
#endif

#endif
