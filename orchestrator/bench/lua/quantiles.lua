-- Prints quantiles of what requests took, in microseconds.
done = function(_, latency, _)
    for name, share in pairs({ ["p50_us"] = 50, ["p99_us"] = 99, ["p99.9_us"] = 99.9 }) do
        io.write(name, " ", latency:percentile(share), "\n")
    end
end
