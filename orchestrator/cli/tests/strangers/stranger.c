/* A controller as other people write it in C: PI, one command each h, over a plain socket.
 *
 *     stranger [each] [early] [seq] [stamp]
 *
 * `each`: a connection for each message; else one is kept. `early`: it is opened before the start. */
#define _GNU_SOURCE
#include <arpa/inet.h>
#include <netinet/tcp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

static struct sockaddr_in plant = {.sin_family = AF_INET};
static char host[64];

static long long now_ns(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return now.tv_sec * 1000000000LL + now.tv_nsec;
}

static int open_plant(void) {
    int one = 1, plug = socket(AF_INET, SOCK_STREAM, 0);
    setsockopt(plug, IPPROTO_TCP, TCP_NODELAY, &one, sizeof one);
    if (plug < 0 || connect(plug, (struct sockaddr *)&plant, sizeof plant)) exit(1);
    return plug;
}

static double ask(int plug, const char *query, int close_after) {
    char text[4096];
    int length = snprintf(text, sizeof text, "GET /closed?%s HTTP/1.1\r\nhost: %s\r\n%s\r\n", query, host,
                          close_after ? "connection: close\r\n" : "");
    if (write(plug, text, length) != length) exit(1);
    int got = 0;
    for (char *body; ; ) {
        int more = read(plug, text + got, sizeof text - 1 - got);
        if (more <= 0) exit(1);
        text[got += more] = 0;
        if ((body = strstr(text, "\r\n\r\n")) && (body = strstr(body, "&y=")) && strstr(body, "&u=")) return atof(body + 3);
    }
}

int main(int count_of_words, char **words) {
    int each = 0, early = 0, seq = 0, stamp = 0, plug = -1, port;
    for (int n = 1; n < count_of_words; n++) {
        each |= !strcmp(words[n], "each");
        early |= !strcmp(words[n], "early");
        seq |= !strcmp(words[n], "seq");
        stamp |= !strcmp(words[n], "stamp");
    }
    if (sscanf(getenv("WEBLOOP_PLANT"), "http://%63[^:]:%d", host, &port) != 2) return 1;
    inet_aton(host, &plant.sin_addr);
    plant.sin_port = htons(port);
    double h = atof(getenv("WEBLOOP_H_S")), r = atof(getenv("WEBLOOP_R")), y = 0, integral = 0;
    long long start = atoll(getenv("WEBLOOP_START_NS")), step = h * 1e9 + 0.5;
    int count = atof(getenv("WEBLOOP_DURATION_S")) / h + 0.5;
    if (early) plug = open_plant();
    for (int k = 0; k < count; k++) {
        long long due = start + k * step;
        if (now_ns() - due >= step) continue;
        struct timespec until = {due / 1000000000LL, due % 1000000000LL};
        clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, 0);
        char query[256];
        double e = r - y;
        integral += 0.378 * h * e;
        int length = snprintf(query, sizeof query, "u=%.17g", 0.1701 * e + integral);
        if (seq) length += snprintf(query + length, sizeof query - length, "&seq=%d", k);
        if (stamp) snprintf(query + length, sizeof query - length, "&t_send_ns=%lld", now_ns());
        if (plug < 0) plug = open_plant();
        y = ask(plug, query, each);
        if (each) {
            close(plug);
            plug = -1;
        }
    }
    return 0;
}
