// What a controller in C++ needs beside its law: what webloop tells it, the plant over HTTP, the loop.
//
// A request at a time, on one kept connection, at the deadlines start + k h. Deadlines that pass while
// an answer is late are skipped. It has no open loop, no WebSocket, and no second request under way.
#pragma once

#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <string>

namespace webloop {

// How long a message waits for its answer, s.
constexpr int timeout_s = 5;

// The longest answer that is read, bytes; a valid one has some 300.
constexpr std::size_t answer_bytes = 16384;

// A time on the clock of WEBLOOP_START_NS, ns.
inline std::int64_t now_ns() {
    timespec now{};
    ::clock_gettime(CLOCK_MONOTONIC, &now);
    return static_cast<std::int64_t>(now.tv_sec) * 1'000'000'000 + now.tv_nsec;
}

// Sleeps until `due_ns`, and not at all if that has passed.
inline void sleep_until(std::int64_t due_ns) {
    timespec due{};
    due.tv_sec = static_cast<time_t>(due_ns / 1'000'000'000);
    due.tv_nsec = static_cast<long>(due_ns % 1'000'000'000);
    while (::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &due, nullptr) == EINTR) {
    }
}

// A variable of the environment. Ends the program if it is not set.
inline std::string told(const char* name) {
    const char* value = std::getenv(name);
    if (value == nullptr) {
        std::fprintf(stderr, "%s is not set; start this program by `webloop run` or `webloop conform`\n",
                     name);
        std::exit(2);
    }
    return value;
}

// A variable that is a number. Ends the program if it is none.
inline double told_number(const char* name) {
    const std::string text = told(name);
    char* end = nullptr;
    const double number = std::strtod(text.c_str(), &end);
    if (text.empty() || *end != '\0' || !std::isfinite(number)) {
        std::fprintf(stderr, "%s is `%s`; give a finite number\n", name, text.c_str());
        std::exit(2);
    }
    return number;
}

// A number that reads back to the same double. In a query the plus sign of 1e+16 would be a space.
inline std::string decimal(double number) {
    char digits[32];
    std::snprintf(digits, sizeof digits, "%.17g", number);
    std::string text = digits;
    text.erase(std::remove(text.begin(), text.end(), '+'), text.end());
    return text;
}

// The plant, on one kept connection.
class Plant {
public:
    // Its address as in WEBLOOP_PLANT, like http://10.77.0.2:8080.
    explicit Plant(const std::string& url) : authority_(url.rfind("http://", 0) == 0 ? url.substr(7) : url) {}

    ~Plant() { disconnect(); }

    Plant(const Plant&) = delete;
    Plant& operator=(const Plant&) = delete;

    // The output y that it answers; nothing if no answer comes in time, or one without y.
    std::optional<double> get(const std::string& path) {
        const std::optional<std::string> body = exchange(path);
        const std::size_t at = body ? body->find("&y=") : std::string::npos;
        if (at == std::string::npos) {
            return std::nullopt;
        }
        return std::strtod(body->c_str() + at + 3, nullptr);
    }

private:
    // The body of an answer. After a failure there is no connection; the next request opens one.
    std::optional<std::string> exchange(const std::string& path) {
        const std::string request = "GET " + path + " HTTP/1.1\r\nHost: " + authority_ + "\r\n\r\n";
        if (!connect() || ::send(socket_, request.data(), request.size(), MSG_NOSIGNAL) !=
                              static_cast<ssize_t>(request.size())) {
            disconnect();
            return std::nullopt;
        }
        std::string answer;
        for (;;) {
            const std::size_t end = answer.find("\r\n\r\n");
            if (end != std::string::npos) {
                const std::string head = lower(answer.substr(0, end + 2));
                const std::string body = answer.substr(end + 4);
                if (body.size() >= length(head)) {
                    if (head.find("\r\nconnection: close\r\n") != std::string::npos) {
                        disconnect();
                    }
                    return body;
                }
            }
            char part[2048];
            const ssize_t bytes = ::recv(socket_, part, sizeof part, 0);
            if (bytes <= 0 || answer.size() > answer_bytes) {
                disconnect();
                return std::nullopt;
            }
            answer.append(part, static_cast<std::size_t>(bytes));
        }
    }

    // The length of a body, by its head in lower case, bytes.
    static std::size_t length(const std::string& head) {
        const std::string name = "\r\ncontent-length:";
        const std::size_t at = head.find(name);
        return at == std::string::npos ? 0 : std::strtoul(head.c_str() + at + name.size(), nullptr, 10);
    }

    static std::string lower(std::string text) {
        std::transform(text.begin(), text.end(), text.begin(),
                       [](unsigned char letter) { return static_cast<char>(std::tolower(letter)); });
        return text;
    }

    // Opens a connection if there is none; whether there is one now.
    bool connect() {
        if (socket_ >= 0) {
            return true;
        }
        const std::size_t colon = authority_.rfind(':');
        const std::string host = authority_.substr(0, colon);
        const std::string port = colon == std::string::npos ? "80" : authority_.substr(colon + 1);
        addrinfo hints{};
        hints.ai_socktype = SOCK_STREAM;
        addrinfo* found = nullptr;
        if (::getaddrinfo(host.c_str(), port.c_str(), &hints, &found) != 0) {
            return false;
        }
        timeval timeout{};
        timeout.tv_sec = timeout_s;
        const int on = 1;
        socket_ = ::socket(found->ai_family, SOCK_STREAM | SOCK_CLOEXEC, 0);
        // The limit on sending is one on connecting too.
        const bool is_open =
            socket_ >= 0 &&
            ::setsockopt(socket_, SOL_SOCKET, SO_SNDTIMEO, &timeout, sizeof timeout) == 0 &&
            ::setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &timeout, sizeof timeout) == 0 &&
            ::setsockopt(socket_, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on) == 0 &&
            ::connect(socket_, found->ai_addr, found->ai_addrlen) == 0;
        ::freeaddrinfo(found);
        return is_open;
    }

    void disconnect() {
        if (socket_ >= 0) {
            ::close(socket_);
        }
        socket_ = -1;
    }

    std::string authority_;
    int socket_ = -1;
};

// Runs the loop with `update(r, y, dt_s)`, which returns u; dt_s is h, or as many h as have passed since
// the last message. Returns the exit code.
template <class Update>
int control(Update update) {
    if (told("WEBLOOP_MODE") != "closed") {
        return 127;  // an open loop is not supported
    }
    const double h_s = told_number("WEBLOOP_H_S");
    const double r = told_number("WEBLOOP_R");
    const std::int64_t h_ns = std::max<std::int64_t>(1, std::llround(h_s * 1e9));
    const std::int64_t start_ns = std::llround(told_number("WEBLOOP_START_NS"));
    const std::int64_t duration_ns = std::llround(told_number("WEBLOOP_DURATION_S") * 1e9);
    Plant plant(told("WEBLOOP_PLANT"));

    std::optional<double> seen;
    while (!seen && now_ns() < start_ns) {
        seen = plant.get("/state");
        if (!seen) {
            sleep_until(std::min(now_ns() + 20'000'000, start_ns));
        }
    }
    double y = seen.value_or(0.0);  // at rest
    std::int64_t k = 0;
    std::int64_t passed = 1;
    for (std::int64_t seq = 0;; ++seq) {
        sleep_until(start_ns + k * h_ns);
        if (k * h_ns >= duration_ns) {
            return 0;
        }
        const double u = update(r, y, static_cast<double>(passed) * h_s);
        y = plant
                .get("/closed?seq=" + std::to_string(seq) + "&t_send_ns=" + std::to_string(now_ns()) +
                     "&u=" + decimal(u))
                .value_or(y);
        passed = std::max<std::int64_t>(1, (now_ns() - start_ns) / h_ns - k);
        k += passed;
    }
}

}  // namespace webloop
