// Interposed file operations of one process: the disk is full, or the process is killed, at the
// operation of a number; with neither, they are listed. Preloaded by `tests/command/writers/disk.rs`.
//
// DISK_AT=N     the operation, from 1; a write stops in its middle
// DISK_FATE     `full`: it and those after it that need room fail; `killed`
// DISK_LOG=FILE one line for each operation: its name and paths

#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

static atomic_long count;

static void list(const char *name, const char *first, const char *second) {
    const char *file = getenv("DISK_LOG");
    if (!file)
        return;
    char line[8300];
    int length = snprintf(line, sizeof line, "%s %s%s%s\n", name, first, second ? " " : "",
                          second ? second : "");
    int log = syscall(SYS_openat, AT_FDCWD, file, O_WRONLY | O_APPEND | O_CREAT, 0600);
    syscall(SYS_write, log, line, length);
    syscall(SYS_close, log);
}

// Counts an operation; whether it fails.
static int fails(int is_write) {
    const char *at = getenv("DISK_AT"), *fate = getenv("DISK_FATE");
    long now = atomic_fetch_add(&count, 1) + 1;
    if (!at || !fate || now < atol(at))
        return 0;
    // The first write stops in its middle.
    if (is_write && now == atol(at))
        return 2;
    if (!strcmp(fate, "killed"))
        kill(getpid(), SIGKILL);
    errno = ENOSPC;
    return 1;
}

static int is_regular(int file) {
    struct stat found;
    return fstat(file, &found) == 0 && S_ISREG(found.st_mode);
}

static const char *path_of(int file, char *path, size_t most) {
    char link[64];
    snprintf(link, sizeof link, "/proc/self/fd/%d", file);
    ssize_t length = readlink(link, path, most - 1);
    path[length < 0 ? 0 : length] = 0;
    return path;
}

#define NEXT(name) ((__typeof__(&name))dlsym(RTLD_NEXT, #name))

ssize_t write(int file, const void *bytes, size_t length) {
    if (file < 3 || !is_regular(file))
        return NEXT(write)(file, bytes, length);
    char path[4096];
    list("write", path_of(file, path, sizeof path), 0);
    switch (fails(1)) {
    case 1: return -1;
    case 2:
        NEXT(write)(file, bytes, length / 2);
        if (!strcmp(getenv("DISK_FATE"), "killed"))
            kill(getpid(), SIGKILL);
        errno = ENOSPC;
        return -1;
    default: return NEXT(write)(file, bytes, length);
    }
}

static int opened(const char *path, int flags, mode_t mode) {
    if (flags & O_CREAT) {
        list("create", path, 0);
        if (fails(0))
            return -1;
    }
    return syscall(SYS_openat, AT_FDCWD, path, flags, mode);
}

int open(const char *path, int flags, ...) {
    va_list rest;
    va_start(rest, flags);
    mode_t mode = flags & O_CREAT ? va_arg(rest, mode_t) : 0;
    va_end(rest);
    return opened(path, flags, mode);
}

int open64(const char *path, int flags, ...) {
    va_list rest;
    va_start(rest, flags);
    mode_t mode = flags & O_CREAT ? va_arg(rest, mode_t) : 0;
    va_end(rest);
    return opened(path, flags, mode);
}

int mkdir(const char *path, mode_t mode) {
    struct stat found;
    if (stat(path, &found) == 0)
        return NEXT(mkdir)(path, mode);
    list("mkdir", path, 0);
    return fails(0) ? -1 : NEXT(mkdir)(path, mode);
}

int rename(const char *from, const char *to) {
    list(access(to, F_OK) ? "rename" : "replace", from, to);
    return fails(0) ? -1 : NEXT(rename)(from, to);
}

int fsync(int file) {
    char path[4096];
    list("sync", path_of(file, path, sizeof path), 0);
    return fails(0) ? -1 : NEXT(fsync)(file);
}

int fdatasync(int file) {
    char path[4096];
    list("sync", path_of(file, path, sizeof path), 0);
    return fails(0) ? -1 : NEXT(fdatasync)(file);
}
