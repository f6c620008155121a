#include "devices/opencl.hpp"

#ifdef POREPACK_WITH_OPENCL
#define CL_TARGET_OPENCL_VERSION 120
#include <CL/cl.h>
#include <dlfcn.h>
#include <fmt/format.h>
#include <signal.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

namespace porepack::devices::opencl {
namespace {

// The functions of the library that are used here.
struct Library {
#define POREPACK_OPENCL_FUNCTIONS(F)                                                                                                     \
    F(clGetPlatformIDs)                                                                                                                  \
    F(clGetDeviceIDs)                                                                                                                    \
    F(clGetDeviceInfo)                                                                                                                   \
    F(clCreateContext)                                                                                                                   \
    F(clReleaseContext)                                                                                                                  \
    F(clCreateCommandQueue)                                                                                                              \
    F(clReleaseCommandQueue)                                                                                                             \
    F(clCreateBuffer)                                                                                                                    \
    F(clReleaseMemObject)                                                                                                                \
    F(clEnqueueWriteBuffer)                                                                                                              \
    F(clEnqueueReadBuffer)                                                                                                               \
    F(clEnqueueFillBuffer) F(clCreateProgramWithSource) F(clBuildProgram) F(clGetProgramBuildInfo) F(clReleaseProgram) F(clCreateKernel) \
        F(clReleaseKernel) F(clSetKernelArg) F(clEnqueueNDRangeKernel) F(clFinish)
#define POREPACK_MEMBER(name) decltype(&::name) name = nullptr;
    POREPACK_OPENCL_FUNCTIONS(POREPACK_MEMBER)
#undef POREPACK_MEMBER
    bool found = false;

    Library() {
        void* const file = dlopen("libOpenCL.so.1", RTLD_NOW | RTLD_LOCAL);
        if (file == nullptr) return;
        found = true;
#define POREPACK_LOAD(name)                                         \
    name = reinterpret_cast<decltype(&::name)>(dlsym(file, #name)); \
    found = found && name != nullptr;
        POREPACK_OPENCL_FUNCTIONS(POREPACK_LOAD)
#undef POREPACK_LOAD
    }
};

const Library& library() {
    static const Library opened;
    return opened;
}

// Drivers that are made with LLVM handle the signals of a program when they compile: after this object the program has its own again.
class KeptSignals {
public:
    KeptSignals() {
        for (std::size_t i = 0; i < signals.size(); ++i) (void)sigaction(signals[i], nullptr, &before_[i]);
    }
    ~KeptSignals() {
        for (std::size_t i = 0; i < signals.size(); ++i) (void)sigaction(signals[i], &before_[i], nullptr);
    }
    KeptSignals(const KeptSignals&) = delete;
    KeptSignals& operator=(const KeptSignals&) = delete;

private:
    static constexpr std::array signals = {SIGHUP, SIGINT, SIGTERM, SIGUSR1, SIGUSR2, SIGPIPE, SIGXFSZ};
    std::array<struct sigaction, signals.size()> before_{};
};

struct Found {
    cl_platform_id platform;
    cl_device_id device;
};

std::vector<Found> all_devices() {
    std::vector<Found> all;
    const Library& cl = library();
    if (!cl.found) return all;
    cl_uint platforms = 0;
    if (cl.clGetPlatformIDs(0, nullptr, &platforms) != CL_SUCCESS || platforms == 0) return all;
    std::vector<cl_platform_id> platform(platforms);
    if (cl.clGetPlatformIDs(platforms, platform.data(), nullptr) != CL_SUCCESS) return all;
    for (const cl_platform_id one : platform) {
        cl_uint devices = 0;
        if (cl.clGetDeviceIDs(one, CL_DEVICE_TYPE_ALL, 0, nullptr, &devices) != CL_SUCCESS || devices == 0) continue;
        std::vector<cl_device_id> device(devices);
        if (cl.clGetDeviceIDs(one, CL_DEVICE_TYPE_ALL, devices, device.data(), nullptr) != CL_SUCCESS) continue;
        for (const cl_device_id here : device) all.push_back({one, here});
    }
    return all;
}

template <typename T>
T number_of(cl_device_id device, cl_device_info what) {
    T value{};
    (void)library().clGetDeviceInfo(device, what, sizeof(T), &value, nullptr);
    return value;
}

std::string text_of(cl_device_id device, cl_device_info what) {
    std::array<char, 1024> text{};
    (void)library().clGetDeviceInfo(device, what, text.size() - 1, text.data(), nullptr);
    return text.data();
}

DeviceInfo info_of(const Found& found, std::size_t number) {
    return {.id = fmt::format("opencl:{}", number),
            .name = text_of(found.device, CL_DEVICE_NAME),
            .driver = text_of(found.device, CL_DRIVER_VERSION),
            .memory_bytes = static_cast<double>(number_of<cl_ulong>(found.device, CL_DEVICE_GLOBAL_MEM_SIZE)),
            .largest_buffer_bytes = static_cast<double>(number_of<cl_ulong>(found.device, CL_DEVICE_MAX_MEM_ALLOC_SIZE)),
            .graphics = (number_of<cl_device_type>(found.device, CL_DEVICE_TYPE) & CL_DEVICE_TYPE_GPU) != 0};
}

class OpenclBuffer : public Buffer {
public:
    OpenclBuffer(cl_mem memory, std::size_t bytes) : memory_(memory), bytes_(bytes) {}
    ~OpenclBuffer() override { (void)library().clReleaseMemObject(memory_); }
    OpenclBuffer(const OpenclBuffer&) = delete;
    OpenclBuffer& operator=(const OpenclBuffer&) = delete;
    [[nodiscard]] std::size_t bytes() const override { return bytes_; }
    [[nodiscard]] cl_mem memory() const { return memory_; }

private:
    cl_mem memory_;
    std::size_t bytes_;
};
cl_mem memory_of(const Buffer& buffer) {
    return dynamic_cast<const OpenclBuffer&>(buffer).memory();
}

class OpenclProgram : public Program {
public:
    explicit OpenclProgram(cl_program program) : program_(program) {}
    ~OpenclProgram() override {
        for (const auto& [name, kernel] : kernels_) (void)library().clReleaseKernel(kernel);
        (void)library().clReleaseProgram(program_);
    }
    OpenclProgram(const OpenclProgram&) = delete;
    OpenclProgram& operator=(const OpenclProgram&) = delete;
    [[nodiscard]] cl_program program() const { return program_; }
    cl_kernel& kernel(const std::string& name) { return kernels_[name]; }

private:
    cl_program program_;
    std::map<std::string, cl_kernel> kernels_;
};

class OpenclDevice : public Device {
public:
    OpenclDevice(const Found& found, std::size_t number) : device_(found.device), info_(info_of(found, number)) {
        if (number_of<cl_device_fp_config>(device_, CL_DEVICE_DOUBLE_FP_CONFIG) == 0)
            throw UserError(info_.name + " has no double precision, which the sums over nodes need",
                            {.where = info_.id, .fix = "--device cpu"});
        cl_int fault = 0;
        const std::array<cl_context_properties, 3> properties = {CL_CONTEXT_PLATFORM,
                                                                 reinterpret_cast<cl_context_properties>(found.platform), 0};
        context_ = cl_.clCreateContext(properties.data(), 1, &device_, nullptr, nullptr, &fault);
        require(fault, "cannot be opened");
        queue_ = cl_.clCreateCommandQueue(context_, device_, 0, &fault);
        require(fault, "cannot be opened");
    }
    ~OpenclDevice() override {
        if (queue_ != nullptr) (void)cl_.clReleaseCommandQueue(queue_);
        if (context_ != nullptr) (void)cl_.clReleaseContext(context_);
    }
    OpenclDevice(const OpenclDevice&) = delete;
    OpenclDevice& operator=(const OpenclDevice&) = delete;

    [[nodiscard]] const DeviceInfo& info() const override { return info_; }
    [[nodiscard]] std::unique_ptr<Buffer> allocate(std::size_t bytes) override {
        cl_int fault = 0;
        const cl_mem memory = cl_.clCreateBuffer(context_, CL_MEM_READ_WRITE, std::max<std::size_t>(bytes, 16), nullptr, &fault);
        if (fault != CL_SUCCESS)
            throw MachineError(fmt::format("{} gives no buffer of {:.3g} GB", info_.name, 1e-9 * static_cast<double>(bytes)),
                               {.where = fmt::format("{}, {:.3g} GB of memory, buffers of at most {:.3g} GB", info_.id,
                                                     1e-9 * info_.memory_bytes, 1e-9 * info_.largest_buffer_bytes),
                                .fix = "choose a larger voxel size, precision = \"single\", or --device cpu"});
        return std::make_unique<OpenclBuffer>(memory, bytes);
    }
    void write(Buffer& to, std::size_t byte, std::span<const std::byte> from) override {
        if (from.empty()) return;
        require(cl_.clEnqueueWriteBuffer(queue_, memory_of(to), CL_TRUE, byte, from.size(), from.data(), 0, nullptr, nullptr), "was lost");
    }
    void read(const Buffer& from, std::size_t byte, std::span<std::byte> to) override {
        if (to.empty()) return;
        require(cl_.clEnqueueReadBuffer(queue_, memory_of(from), CL_TRUE, byte, to.size(), to.data(), 0, nullptr, nullptr), "was lost");
    }
    void fill_with_zeros(Buffer& buffer) override {
        const std::uint32_t zero = 0;
        const std::size_t bytes = std::max<std::size_t>(16, buffer.bytes() / 4 * 4);
        require(cl_.clEnqueueFillBuffer(queue_, memory_of(buffer), &zero, sizeof(zero), 0, bytes, 0, nullptr, nullptr), "was lost");
    }
    [[nodiscard]] std::shared_ptr<Program> compile(const ProgramText& text) override {
        const KeptSignals kept;
        std::string options = "-cl-std=CL1.2";
        for (const std::string& definition : text.definitions) options += " -D" + definition;
        std::shared_ptr<OpenclProgram>& program = programs_[options + std::string(text.text)];
        if (!program) program = compiled(text.text, options);
        return program;
    }
    void run(Program& program, const std::string& name, std::size_t groups, std::size_t group_size,
             std::span<const Argument> arguments) override {
        auto& compiled = dynamic_cast<OpenclProgram&>(program);
        cl_kernel& kernel = compiled.kernel(name);
        std::optional<KeptSignals> kept;
        if (kernel == nullptr) {
            kept.emplace();  // some drivers compile when a kernel runs
            cl_int fault = 0;
            kernel = cl_.clCreateKernel(compiled.program(), name.c_str(), &fault);
            require(fault, "has not the kernel " + name);
        }
        cl_uint number = 0;
        for (const Argument& argument : arguments) {
            cl_int fault = 0;
            if (const auto* const* buffer = std::get_if<const Buffer*>(&argument.value)) {
                const cl_mem memory = memory_of(**buffer);
                fault = cl_.clSetKernelArg(kernel, number++, sizeof(memory), &memory);
            } else if (const auto* shared = std::get_if<Argument::SharedBytes>(&argument.value)) {
                fault = cl_.clSetKernelArg(kernel, number++, shared->bytes, nullptr);
            } else {
                const auto& bytes = std::get<std::vector<std::byte>>(argument.value);
                fault = cl_.clSetKernelArg(kernel, number++, bytes.size(), bytes.data());
            }
            require(fault, fmt::format("does not take argument {} of {}", number, name));
        }
        const std::size_t threads = groups * group_size;
        require(cl_.clEnqueueNDRangeKernel(queue_, kernel, 1, nullptr, &threads, &group_size, 0, nullptr, nullptr),
                fmt::format("cannot run {}", name));
        if (kept) finish();
    }
    void finish() override { require(cl_.clFinish(queue_), "was lost"); }

private:
    std::shared_ptr<OpenclProgram> compiled(std::string_view text, const std::string& options) const {
        const char* begin = text.data();
        const std::size_t length = text.size();
        cl_int fault = 0;
        auto program = std::make_shared<OpenclProgram>(cl_.clCreateProgramWithSource(context_, 1, &begin, &length, &fault));
        require(fault, "cannot be opened");
        if (cl_.clBuildProgram(program->program(), 1, &device_, options.c_str(), nullptr, nullptr) == CL_SUCCESS) return program;
        std::vector<char> log(20000);
        (void)cl_.clGetProgramBuildInfo(program->program(), device_, CL_PROGRAM_BUILD_LOG, log.size() - 1, log.data(), nullptr);
        throw EngineError(fmt::format("{} does not compile the kernels:\n{}", info_.name, log.data()),
                          {.where = info_.id, .fix = "--device cpu, or another driver"});
    }
    void require(cl_int fault, const std::string& what) const {
        if (fault == CL_SUCCESS) return;
        if (fault == CL_MEM_OBJECT_ALLOCATION_FAILURE || fault == CL_OUT_OF_HOST_MEMORY)
            throw MachineError(fmt::format("{} has not enough free memory", info_.name),
                               {.where = fmt::format("{}, {:.3g} GB", info_.id, 1e-9 * info_.memory_bytes),
                                .fix = "choose a larger voxel size, precision = \"single\", or --device cpu"});
        throw DeviceLost(fmt::format("the device {} ({}) {}: OpenCL error {}", info_.id, info_.name, what, fault),
                         {.fix = "run the same command again: it resumes from its checkpoint; or choose another --device"});
    }

    const Library& cl_ = library();
    cl_device_id device_;
    DeviceInfo info_;
    cl_context context_ = nullptr;
    cl_command_queue queue_ = nullptr;
    std::map<std::string, std::shared_ptr<OpenclProgram>> programs_;
};

}  // namespace

std::vector<DeviceInfo> find_devices() {
    const KeptSignals kept;
    std::vector<DeviceInfo> all;
    for (const Found& found : all_devices()) all.push_back(info_of(found, all.size()));
    return all;
}

std::shared_ptr<Device> open_device(std::size_t number) {
    const std::vector<Found> all = all_devices();
    if (number >= all.size()) return nullptr;
    return std::make_shared<OpenclDevice>(all[number], number);
}

}  // namespace porepack::devices::opencl

#else

namespace porepack::devices::opencl {
std::vector<DeviceInfo> find_devices() {
    return {};
}
std::shared_ptr<Device> open_device(std::size_t) {
    return nullptr;
}
}  // namespace porepack::devices::opencl
#endif
