/* Tests of the C interface: results, wrong arguments, threads, cancellation. It makes its own meshes, prints times, and ends with 0 if
 * everything holds. With the argument "unmeasured" no times are measured and the meshes are smaller, for a run under valgrind. */
#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "isomend.h"

static int failures = 0;
/* Vertices along a side of the small sheets, and quads along a side of a marked region. */
static uint32_t side = 30, marked = 8;

#define HOLDS(condition)                                                                                              \
    do {                                                                                                              \
        if (!(condition)) {                                                                                           \
            fprintf(stderr, "line %d: %s does not hold; last error: %s\n", __LINE__, #condition, isomend_last_error()); \
            failures++;                                                                                               \
        }                                                                                                             \
    } while (0)

static double now(void)
{
    struct timespec time;
    clock_gettime(CLOCK_MONOTONIC, &time);
    return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

/* A height field of n * n vertices over the square from -1 to 1, with `holes` * `holes` holes. */
static isomend_mesh *sheet(uint32_t n, uint32_t holes, int is_f32)
{
    double *vertices = malloc(sizeof(double) * 3 * n * n);
    float *floats = malloc(sizeof(float) * 3 * n * n);
    uint32_t *faces = malloc(sizeof(uint32_t) * 6 * n * n);
    size_t corners = 0;
    for (uint32_t i = 0; i < n; i++)
        for (uint32_t j = 0; j < n; j++) {
            double x = 2.0 * i / (n - 1) - 1, y = 2.0 * j / (n - 1) - 1;
            double row[3] = {x, y, 0.2 * sin(2 * x) * cos(2 * y)};
            memcpy(vertices + 3 * (i * n + j), row, sizeof row);
            for (int k = 0; k < 3; k++)
                floats[3 * (i * n + j) + (size_t)k] = (float)row[k];
            double u = fmod((x + 1) * 0.5 * holes, 1.0), v = fmod((y + 1) * 0.5 * holes, 1.0);
            if (i + 1 == n || j + 1 == n || hypot(u - 0.5, v - 0.5) < 0.25)
                continue;
            uint32_t a = i * n + j, b = a + n, c = b + 1, d = a + 1;
            uint32_t quad[6] = {a, b, c, a, c, d};
            memcpy(faces + corners, quad, sizeof quad);
            corners += 6;
        }
    isomend_mesh *mesh = NULL;
    if (is_f32)
        HOLDS(isomend_mesh_f32(floats, (size_t)n * n, faces, corners / 3, &mesh) == ISOMEND_OK);
    else
        HOLDS(isomend_mesh_f64(vertices, (size_t)n * n, faces, corners / 3, &mesh) == ISOMEND_OK);
    free(vertices);
    free(floats);
    free(faces);
    return mesh;
}

static void results(void)
{
    isomend_mesh *mesh = sheet(side, 1, 1);
    isomend_result *results[2];
    for (uint32_t threads = 1; threads <= 2; threads++) {
        isomend_options options = {.threads = threads};
        HOLDS(isomend_fill(mesh, "", &options, &results[threads - 1]) == ISOMEND_OK);
    }
    isomend_mesh_free(mesh);
    isomend_result *r = results[0];
    size_t vertices = isomend_result_vertex_count(r), faces = isomend_result_face_count(r);
    HOLDS(vertices > side * side && isomend_result_is_complete(r));
    HOLDS(vertices == isomend_result_vertex_count(results[1]));
    HOLDS(memcmp(isomend_result_vertices(r), isomend_result_vertices(results[1]), 3 * vertices * sizeof(double)) == 0);
    HOLDS(memcmp(isomend_result_faces(r), isomend_result_faces(results[1]), 3 * faces * sizeof(uint32_t)) == 0);
    float *floats = malloc(3 * vertices * sizeof(float));
    HOLDS(isomend_result_vertices_f32(r, floats, 3 * vertices - 1) == ISOMEND_ARGUMENT);
    HOLDS(isomend_result_vertices_f32(r, floats, 3 * vertices) == ISOMEND_OK);
    for (size_t i = 0; i < 3 * vertices; i++)
        HOLDS(floats[i] == (float)isomend_result_vertices(r)[i]);
    for (size_t v = 0; v < vertices; v++) {
        int is_new = v >= side * side;
        HOLDS(isomend_result_vertex_origins(r)[v] == (is_new ? ISOMEND_NEW : v));
        HOLDS(is_new || isomend_result_expected_errors(r)[v] == 0);
    }
    size_t fresh = 0;
    for (size_t f = 0; f < faces; f++) {
        fresh += isomend_result_face_origins(r)[f] == ISOMEND_NEW;
        HOLDS(fresh > 0 || isomend_result_face_origins(r)[f] == f);
        for (int k = 0; k < 3; k++)
            HOLDS(isomend_result_faces(r)[3 * f + (size_t)k] < vertices);
    }
    HOLDS(fresh > 10);
    HOLDS(strstr(isomend_result_report(r), "\"holes\":") != NULL);
    free(floats);
    isomend_result_free(results[0]);
    isomend_result_free(results[1]);
}

static void questions(void)
{
    isomend_mesh *mesh = sheet(side, 1, 0);
    char *report = NULL;
    bool is_sound = true;
    HOLDS(isomend_check(mesh, "{\"thin\": 0.1, \"unit\": \"mm\"}", NULL, &is_sound, &report) == ISOMEND_OK);
    HOLDS(!is_sound && report && strstr(report, "\"mm\""));
    isomend_text_free(report);
    HOLDS(isomend_check(mesh, NULL, NULL, NULL, NULL) == ISOMEND_OK);
    is_sound = true;
    HOLDS(isomend_check(mesh, NULL, NULL, &is_sound, NULL) == ISOMEND_OK && !is_sound);
    HOLDS(isomend_inspect(mesh, NULL, NULL, &report) == ISOMEND_OK && strstr(report, "\"holes\":"));
    isomend_text_free(report);
    HOLDS(isomend_parameters("repair", &report) == ISOMEND_OK && strstr(report, "\"solid\":"));
    isomend_text_free(report);
    isomend_result *result;
    HOLDS(isomend_repair(mesh, "{\"close_borders\": true}", NULL, &result) == ISOMEND_OK);
    HOLDS(isomend_result_is_complete(result));
    isomend_result_free(result);
    isomend_mesh_free(mesh);
}

/* Whether the faces that a result kept are those that are not marked, in order. */
static int keeps_others(const isomend_result *r, const bool *is_marked, size_t faces)
{
    const uint32_t *origins = isomend_result_face_origins(r);
    size_t at = 0;
    for (uint32_t f = 0; f < faces; f++)
        if (!is_marked[f] && (at >= isomend_result_face_count(r) || origins[at++] != f))
            return 0;
    return at < isomend_result_face_count(r) && origins[at] == ISOMEND_NEW;
}

/* Marked faces are replaced and smoothed, named by themselves or by their vertices. */
static void masks(void)
{
    enum { N = 30, FACES = 2 * (N - 1) * (N - 1) };
    static bool is_marked[FACES];
    isomend_mesh *mesh = sheet(N, 0, 0);
    uint32_t faces[FACES], vertices[N * N];
    isomend_mask by_faces = {.faces = faces}, by_vertices = {.vertices = vertices};
    for (uint32_t i = 10; i <= 10 + marked; i++)
        for (uint32_t j = 10; j <= 10 + marked; j++) {
            vertices[by_vertices.vertex_count++] = i * N + j;
            for (uint32_t half = 0; half < 2 && i < 10 + marked && j < 10 + marked; half++) {
                uint32_t face = 2 * (i * (N - 1) + j) + half;
                is_marked[face] = true;
                faces[by_faces.face_count++] = face;
            }
        }
    isomend_result *r[2] = {NULL, NULL};
    HOLDS(isomend_restore(mesh, &by_faces, "{\"tolerance\": 0.1}", NULL, &r[0]) == ISOMEND_OK);
    HOLDS(isomend_restore(mesh, &by_vertices, NULL, NULL, &r[1]) == ISOMEND_OK);
    HOLDS(isomend_result_is_complete(r[0]) && keeps_others(r[0], is_marked, FACES));
    size_t count = isomend_result_vertex_count(r[0]);
    HOLDS(count == isomend_result_vertex_count(r[1]));
    HOLDS(memcmp(isomend_result_vertices(r[0]), isomend_result_vertices(r[1]), 3 * count * sizeof(double)) == 0);
    uint32_t before = 0;
    for (size_t v = 0; v < count && isomend_result_vertex_origins(r[0])[v] != ISOMEND_NEW; v++) {
        HOLDS(v == 0 || isomend_result_vertex_origins(r[0])[v] > before);
        before = isomend_result_vertex_origins(r[0])[v];
        HOLDS(isomend_result_expected_errors(r[0])[v] == 0);
    }
    HOLDS(before == N * N - 1 && strstr(isomend_result_report(r[0]), "\"restore\""));
    isomend_result_free(r[0]);
    isomend_result_free(r[1]);
    r[0] = r[1] = NULL;
    HOLDS(isomend_fair(mesh, &by_faces, "{\"strength\": 0.4}", NULL, &r[0]) == ISOMEND_OK);
    HOLDS(isomend_result_is_complete(r[0]) && keeps_others(r[0], is_marked, FACES));
    isomend_result_free(r[0]);
    isomend_mesh_free(mesh);
}

/* A call that must fail, and a part of its message. */
#define FAILS(call, expected, part)                                                          \
    do {                                                                                     \
        HOLDS((call) == (expected));                                                         \
        if (!strstr(isomend_last_error(), part))                                             \
            fprintf(stderr, "no \"%s\" in: %s\n", part, isomend_last_error()), failures++; \
    } while (0)

/* Misaligned pointers are refused before the work, and nothing is set. */
static void misaligned(const isomend_mesh *mesh)
{
    bool is_sound = true;
    char *texts[2] = {NULL, NULL};
    char **text = (char **)((char *)texts + 1);
    FAILS(isomend_check(mesh, NULL, NULL, &is_sound, text), ISOMEND_ARGUMENT, "report is not aligned");
    FAILS(isomend_inspect(mesh, NULL, NULL, text), ISOMEND_ARGUMENT, "report is not aligned");
    FAILS(isomend_parameters("fill", text), ISOMEND_ARGUMENT, "schema is not aligned");
    FAILS(isomend_fill(mesh, NULL, NULL, (isomend_result **)text), ISOMEND_ARGUMENT, "result is not aligned");
    HOLDS(is_sound && !texts[0] && !texts[1]);
    isomend_options options[2] = {{0}, {0}};
    const isomend_options *shifted = (const isomend_options *)((const char *)options + 1);
    FAILS(isomend_check(mesh, NULL, shifted, &is_sound, NULL), ISOMEND_ARGUMENT, "options is not aligned");
    isomend_cancel *cancel = isomend_cancel_new();
    options[0].cancel = (const isomend_cancel *)((const char *)cancel + 1);
    FAILS(isomend_check(mesh, NULL, options, &is_sound, NULL), ISOMEND_ARGUMENT, "options.cancel is not aligned");
    isomend_cancel_free(cancel);
}

/* Masks of a tetrahedron with three faces. */
static void wrong_masks(const isomend_mesh *mesh)
{
    uint32_t numbers[2] = {0, 7};
    isomend_mask mask = {0};
    isomend_result *result = NULL;
    FAILS(isomend_restore(mesh, NULL, NULL, NULL, &result), ISOMEND_ARGUMENT, "mask is a null pointer");
    FAILS(isomend_restore(mesh, &mask, NULL, NULL, &result), ISOMEND_PARAMETER, "marks no face");
    FAILS(isomend_fair(mesh, &mask, NULL, NULL, &result), ISOMEND_PARAMETER, "marks no face");
    mask.face_count = 2;
    FAILS(isomend_restore(mesh, &mask, NULL, NULL, &result), ISOMEND_ARGUMENT, "mask.faces is a null pointer");
    mask.faces = numbers;
    FAILS(isomend_restore(mesh, &mask, NULL, NULL, &result), ISOMEND_PARAMETER, "names face 7");
    mask = (isomend_mask){.vertices = numbers, .vertex_count = 2};
    FAILS(isomend_restore(mesh, &mask, NULL, NULL, &result), ISOMEND_PARAMETER, "names vertex 7");
    mask.vertex_count = 1;
    FAILS(isomend_fair(mesh, &mask, NULL, NULL, &result), ISOMEND_PARAMETER, "none has its three vertices");
    mask = (isomend_mask){.faces = numbers, .face_count = 1, .grow = -1};
    FAILS(isomend_restore(mesh, &mask, NULL, NULL, &result), ISOMEND_PARAMETER, "grow");
    mask.grow = 0;
    FAILS(isomend_restore(mesh, &mask, "{\"holes\": [1]}", NULL, &result), ISOMEND_PARAMETER, "restore has no parameter 'holes'");
    FAILS(isomend_fair(mesh, &mask, "{\"tolerance\": 1}", NULL, &result), ISOMEND_PARAMETER, "fair has no parameter 'tolerance'");
    FAILS(isomend_restore(mesh, (isomend_mask *)((char *)&mask + 1), NULL, NULL, &result), ISOMEND_ARGUMENT, "mask is not aligned");
    HOLDS(result == NULL);
}

static void wrong_arguments(void)
{
    double vertices[12] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
    uint32_t faces[9] = {0, 2, 1, 0, 1, 3, 0, 3, 2};
    uint32_t beyond[3] = {0, 1, 4};
    isomend_mesh *mesh = NULL;
    isomend_result *result = NULL;
    char *text = NULL;
    FAILS(isomend_mesh_f64(NULL, 4, faces, 3, &mesh), ISOMEND_ARGUMENT, "vertices is a null pointer");
    FAILS(isomend_mesh_f64(vertices, 4, faces, 3, NULL), ISOMEND_ARGUMENT, "mesh is a null pointer");
    FAILS(isomend_mesh_f64(vertices, 4, beyond, 1, &mesh), ISOMEND_MESH, "face 0 refers to vertex 4");
    FAILS(isomend_mesh_f64(vertices, SIZE_MAX / 2, faces, 3, &mesh), ISOMEND_ARGUMENT, "more than memory");
    FAILS(isomend_mesh_f64((double *)((char *)vertices + 1), 2, faces, 0, &mesh), ISOMEND_ARGUMENT, "not aligned");
    HOLDS(mesh == NULL);
    HOLDS(isomend_mesh_f64(NULL, 0, NULL, 0, &mesh) == ISOMEND_OK);
    FAILS(isomend_fill(mesh, NULL, NULL, &result), ISOMEND_MESH, "");
    isomend_mesh_free(mesh);
    vertices[4] = NAN;
    HOLDS(isomend_mesh_f64(vertices, 4, faces, 3, &mesh) == ISOMEND_OK);
    FAILS(isomend_fill(mesh, NULL, NULL, &result), ISOMEND_MESH, "finite");
    isomend_mesh_free(mesh);
    vertices[4] = 0;
    HOLDS(isomend_mesh_f64(vertices, 4, faces, 3, &mesh) == ISOMEND_OK);
    FAILS(isomend_fill(NULL, NULL, NULL, &result), ISOMEND_ARGUMENT, "mesh is a null pointer");
    FAILS(isomend_fill(mesh, NULL, NULL, NULL), ISOMEND_ARGUMENT, "result is a null pointer");
    FAILS(isomend_fill(mesh, "{\"nothing\": 1}", NULL, &result), ISOMEND_PARAMETER, "fill has no parameter 'nothing'");
    FAILS(isomend_fill(mesh, "{\"voxel\": -1}", NULL, &result), ISOMEND_PARAMETER, "voxel must be");
    FAILS(isomend_fill(mesh, "[1]", NULL, &result), ISOMEND_PARAMETER, "no JSON object");
    FAILS(isomend_fill(mesh, "{\"holes\": [", NULL, &result), ISOMEND_PARAMETER, "no JSON object");
    FAILS(isomend_fill(mesh, "{\"holes\": [7]}", NULL, &result), ISOMEND_PARAMETER, "there is no hole 7");
    FAILS(isomend_fill(mesh, "{\"like\": \"no such file.ply\"}", NULL, &result), ISOMEND_FILE, "no such file.ply");
    FAILS(isomend_check(mesh, "{\"voxel\": 1}", NULL, NULL, NULL), ISOMEND_PARAMETER, "check has no parameter 'voxel'");
    FAILS(isomend_inspect(mesh, "{\"voxel\": 1}", NULL, &text), ISOMEND_PARAMETER, "inspect has no parameter 'voxel'");
    FAILS(isomend_parameters("study", &text), ISOMEND_PARAMETER, "take fill, repair, restore, fair or check");
    wrong_masks(mesh);
    FAILS(isomend_parameters(NULL, &text), ISOMEND_ARGUMENT, "command is a null pointer");
    FAILS(isomend_parameters("fill", NULL), ISOMEND_ARGUMENT, "schema is a null pointer");
    FAILS(isomend_inspect(mesh, NULL, NULL, NULL), ISOMEND_ARGUMENT, "report is a null pointer");
    FAILS(isomend_check(mesh, "{\"tolerance\": 1}", NULL, NULL, &text), ISOMEND_PARAMETER, "check has no parameter 'tolerance'");
    FAILS(isomend_inspect(mesh, "{\"tolerance\": 1}", NULL, &text), ISOMEND_PARAMETER, "inspect has no parameter 'tolerance'");
    misaligned(mesh);
    isomend_options options = {.threads = 100000};
    FAILS(isomend_fill(mesh, NULL, &options, &result), ISOMEND_PARAMETER, "100000 threads");
    HOLDS(result == NULL && text == NULL);
    HOLDS(isomend_result_vertex_count(NULL) == 0 && isomend_result_vertices(NULL) == NULL && !isomend_result_is_complete(NULL));
    isomend_mesh_free(mesh);
    isomend_mesh_free(NULL);
    isomend_result_free(NULL);
    isomend_text_free(NULL);
    isomend_cancel_set(NULL);
    isomend_cancel_free(NULL);
}

struct stop {
    isomend_cancel *cancel;
    double after, at;
};

static void *stop_later(void *given)
{
    struct stop *stop = given;
    struct timespec pause = {(time_t)stop->after, (long)(1e9 * fmod(stop->after, 1))};
    nanosleep(&pause, NULL);
    stop->at = now();
    isomend_cancel_set(stop->cancel);
    return NULL;
}

static int smaller(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* A call with a token that is set already does nothing. */
static void stopped_before(void)
{
    isomend_mesh *mesh = sheet(side, 1, 0);
    isomend_cancel *cancel = isomend_cancel_new();
    isomend_options options = {.cancel = cancel};
    isomend_result *result = NULL;
    isomend_cancel_set(cancel);
    HOLDS(isomend_fill(mesh, NULL, &options, &result) == ISOMEND_CANCELLED && result == NULL);
    HOLDS(isomend_repair(mesh, NULL, &options, &result) == ISOMEND_CANCELLED && result == NULL);
    uint32_t face = 0;
    isomend_mask mask = {.faces = &face, .face_count = 1, .grow = 0.1};
    HOLDS(isomend_restore(mesh, &mask, NULL, &options, &result) == ISOMEND_CANCELLED && result == NULL);
    HOLDS(isomend_fair(mesh, NULL, NULL, &options, &result) == ISOMEND_CANCELLED && result == NULL);
    isomend_cancel_free(cancel);
    isomend_mesh_free(mesh);
}

enum { ROUNDS = 8 };

/*
 * Stops fills and repairs at various times: they return at once, in a small part of the time that a fill takes. Where nothing else runs it
 * is less than 50 ms, which is printed.
 */
static void cancellation(void)
{
    isomend_mesh *mesh = sheet(130, 4, 0);
    double late[ROUNDS] = {0}, begin = now();
    int stopped = 0;
    isomend_result *whole = NULL;
    HOLDS(isomend_fill(mesh, NULL, NULL, &whole) == ISOMEND_OK);
    isomend_result_free(whole);
    double all = now() - begin;
    for (int round = 0; round < ROUNDS; round++) {
        struct stop stop = {isomend_cancel_new(), all * (round + 1) / 20, 0};
        isomend_options options = {.cancel = stop.cancel};
        isomend_result *result = NULL;
        pthread_t thread;
        pthread_create(&thread, NULL, stop_later, &stop);
        isomend_status status = (round % 2 ? isomend_repair : isomend_fill)(mesh, NULL, &options, &result);
        double end = now();
        pthread_join(thread, NULL);
        HOLDS(status == ISOMEND_OK || status == ISOMEND_CANCELLED);
        if (status == ISOMEND_CANCELLED) {
            HOLDS(strstr(isomend_last_error(), "stopped"));
            late[stopped++] = end - stop.at;
        }
        isomend_result_free(result);
        isomend_cancel_free(stop.cancel);
    }
    HOLDS(stopped > 0);
    qsort(late, (size_t)stopped, sizeof late[0], smaller);
    double median = late[stopped / 2], worst = late[stopped > 0 ? stopped - 1 : 0];
    printf("%d of %d calls were stopped; they returned after %.1f ms (median), %.1f ms (slowest); a whole fill takes %.1f s\n",
           stopped, ROUNDS, 1e3 * median, 1e3 * worst, all);
    HOLDS(median < 0.2 * all);
    isomend_mesh_free(mesh);
}

/* Stops at the third call, and counts the calls. */
static int32_t third(double part, size_t done, size_t all, void *user)
{
    int *calls = user;
    HOLDS(part >= 0 && part <= 1 && done <= all);
    return ++*calls == 3;
}

static void progress(void)
{
    isomend_mesh *mesh = sheet(8 * side, 2 * side / 5, 0);
    isomend_result *result = NULL;
    int calls = 0;
    isomend_options options = {.progress = third, .user = &calls};
    HOLDS(isomend_fill(mesh, NULL, &options, &result) == ISOMEND_CANCELLED);
    HOLDS(calls == 3 && result == NULL);
    isomend_mesh_free(mesh);
}

struct shared {
    isomend_mesh *mesh;
    size_t faces;
};

/* Fails when the thread's own data are destroyed. */
static void fails_at_the_end(void *schema)
{
    HOLDS(isomend_parameters("study", schema) == ISOMEND_PARAMETER);
    HOLDS(isomend_last_error() != NULL);
}

static void *fail_first(void *key)
{
    static char *schema = NULL;
    pthread_setspecific(*(pthread_key_t *)key, &schema);
    HOLDS(isomend_parameters("study", &schema) == ISOMEND_PARAMETER);
    return NULL;
}

static void destructors(void)
{
    pthread_key_t key;
    pthread_t thread;
    HOLDS(pthread_key_create(&key, fails_at_the_end) == 0);
    pthread_create(&thread, NULL, fail_first, &key);
    pthread_join(thread, NULL);
    pthread_key_delete(key);
}

static void *fill_shared(void *given)
{
    struct shared *shared = given;
    isomend_result *result = NULL;
    HOLDS(isomend_fill(shared->mesh, NULL, NULL, &result) == ISOMEND_OK);
    HOLDS(isomend_fill(shared->mesh, "{", NULL, &result) == ISOMEND_PARAMETER);
    shared->faces = isomend_result_face_count(result);
    isomend_result_free(result);
    return NULL;
}

static void shared_by_threads(void)
{
    isomend_mesh *mesh = sheet(side, 1, 0);
    struct shared shared[3] = {{mesh, 0}, {mesh, 0}, {mesh, 0}};
    pthread_t threads[3];
    for (int i = 0; i < 3; i++)
        pthread_create(&threads[i], NULL, fill_shared, &shared[i]);
    for (int i = 0; i < 3; i++)
        pthread_join(threads[i], NULL);
    HOLDS(shared[0].faces > 0 && shared[0].faces == shared[1].faces && shared[1].faces == shared[2].faces);
    isomend_mesh_free(mesh);
}

int main(int count, char **arguments)
{
    /* Under valgrind nothing is measured. */
    bool measures = count < 2 || strcmp(arguments[1], "unmeasured") != 0;
    if (!measures)
        side = 12, marked = 3;
    HOLDS(isomend_abi_version() == ISOMEND_ABI_VERSION && strlen(isomend_version()) > 4);
    results();
    questions();
    masks();
    wrong_arguments();
    shared_by_threads();
    destructors();
    progress();
    stopped_before();
    if (measures)
        cancellation();
    if (failures)
        fprintf(stderr, "%d conditions do not hold\n", failures);
    return failures ? 1 : 0;
}
