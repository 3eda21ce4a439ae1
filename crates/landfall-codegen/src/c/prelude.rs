//! The start of every generated header, guarded so that one file can include several headers.

/// The includes, the row type of tables, and the lookup function.
pub(super) const PRELUDE: &str = r#"#include <assert.h>
#include <stddef.h>
#include <stdint.h>

#ifndef LANDFALL_LEAF
#define LANDFALL_LEAF 1

/* What a leaf's components are. */
typedef enum landfall_kind {
    LANDFALL_BOOL,
    LANDFALL_INT,
    LANDFALL_UINT,
    LANDFALL_FLOAT,
    LANDFALL_BFLOAT,
    LANDFALL_FLOAT_E5M2,
    LANDFALL_FLOAT_E4M3,
    LANDFALL_ADDRESS
} landfall_kind;

/* A scalar, vector or matrix of a block; arrays on the way to it are patterns.
 * Element [i][j] is at offset + i * strides[0] + j * strides[1]. */
typedef struct landfall_leaf {
    const char *path;       /* `data[].color` */
    const char *type;       /* as the shader spells it */
    landfall_kind kind;     /* of one component */
    uint32_t width;         /* bytes of one component; a bool has 4 */
    uint32_t columns;       /* of a matrix; 1 for the others */
    uint32_t rows;          /* components of a vector or column */
    uint32_t row_major;     /* whether a matrix is stored by rows */
    uint32_t matrix_stride; /* bytes from column to column, or from row to row */
    uint64_t offset;        /* of its first element, from the start of the block */
    uint64_t size;          /* bytes of one element */
    uint32_t dim_count;     /* array dimensions on the way */
    uint32_t dims[8];       /* outermost first; 0 is runtime-sized */
    uint64_t strides[8];    /* bytes from element to element */
} landfall_leaf;

/* Byte offset of a path such as `data[3].color`, or -1 when there is none of
 * that name or an index is out of range. Allocates nothing. The row of the
 * table is stored to *found unless that is NULL. */
static inline int64_t landfall_lookup(const landfall_leaf *leaves, size_t count,
                                      const char *path, const landfall_leaf **found)
{
    for (size_t at = 0; at < count; at++) {
        const landfall_leaf *leaf = &leaves[at];
        const char *want = leaf->path;
        const char *given = path;
        uint64_t offset = leaf->offset;
        uint32_t dim = 0;
        while (*want != '\0' && *want == *given) {
            given++;
            if (*want++ == '[') {
                uint64_t index = 0;
                const char *first = given;
                while (*given >= '0' && *given <= '9' && index <= UINT32_MAX) {
                    index = index * 10 + (uint64_t)(*given++ - '0');
                }
                if (given == first || index > UINT32_MAX) {
                    break;
                }
                if (leaf->dims[dim] != 0 && index >= leaf->dims[dim]) {
                    break;
                }
                offset += index * leaf->strides[dim++];
            }
        }
        if (*want == '\0' && *given == '\0' && offset <= INT64_MAX) {
            if (found != NULL) {
                *found = leaf;
            }
            return (int64_t)offset;
        }
    }
    return -1;
}

#endif
"#;

/// Guards a definition that several headers share; a second one with different `facts` is an
/// `#error`.
pub(super) fn once(guard: &str, what: &str, facts: &str, text: &str) -> String {
    let hash = hash(facts);
    format!(
        "#ifndef {guard}\n\
         #define {guard} 0x{hash:016x}u\n\
         {text}\
         #elif {guard} != 0x{hash:016x}u\n\
         #error \"{what} is different in a header included before: \
         generate both as one header, or give one a prefix\"\n\
         #endif\n"
    )
}

/// The 64-bit FNV-1a hash, with its offset basis and prime.
fn hash(text: &str) -> u64 {
    text.bytes().fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3)
    })
}
