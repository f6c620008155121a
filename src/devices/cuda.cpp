#include "devices/cuda.hpp"

#ifdef POREPACK_WITH_CUDA
#include <dlfcn.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <type_traits>
#include <variant>
#include <vector>

namespace porepack::devices::cuda {

namespace {

// The driver's interface, as far as it is used here: its headers come with CUDA only.
using Result = int;
using Ordinal = int;
using Context = void*;
using Module = void*;
using Function = void*;
using Address = unsigned long long;
constexpr Result success = 0;
constexpr int attribute_of_shared_bytes = 8;  // CU_FUNC_ATTRIBUTE_MAX_DYNAMIC_SHARED_SIZE_BYTES

struct Library {
    Result (*init)(unsigned) = nullptr;
    Result (*count)(int*) = nullptr;
    Result (*device)(Ordinal*, int) = nullptr;
    Result (*name)(char*, int, Ordinal) = nullptr;
    Result (*memory)(std::size_t*, Ordinal) = nullptr;
    Result (*version)(int*) = nullptr;
    Result (*retain)(Context*, Ordinal) = nullptr;
    Result (*release)(Ordinal) = nullptr;
    Result (*make_current)(Context) = nullptr;
    Result (*allocate)(Address*, std::size_t) = nullptr;
    Result (*free)(Address) = nullptr;
    Result (*to_device)(Address, const void*, std::size_t) = nullptr;
    Result (*from_device)(void*, Address, std::size_t) = nullptr;
    Result (*fill)(Address, unsigned char, std::size_t) = nullptr;
    Result (*load)(Module*, const void*) = nullptr;
    Result (*unload)(Module) = nullptr;
    Result (*function)(Function*, Module, const char*) = nullptr;
    Result (*set_attribute)(Function, int, int) = nullptr;
    Result (*launch)(Function, unsigned, unsigned, unsigned, unsigned, unsigned, unsigned, unsigned, void*, void**, void**) = nullptr;
    Result (*synchronise)() = nullptr;
    Result (*error_name)(Result, const char**) = nullptr;
    bool found = false;

    Library() {
        void* const file = dlopen("libcuda.so.1", RTLD_NOW | RTLD_LOCAL);
        if (file == nullptr) return;
        found = true;
        const auto get = [&](auto& function_pointer, const char* symbol) {
            function_pointer = reinterpret_cast<std::remove_reference_t<decltype(function_pointer)>>(dlsym(file, symbol));
            found = found && function_pointer != nullptr;
        };
        get(init, "cuInit");
        get(count, "cuDeviceGetCount");
        get(device, "cuDeviceGet");
        get(name, "cuDeviceGetName");
        get(memory, "cuDeviceTotalMem_v2");
        get(version, "cuDriverGetVersion");
        get(retain, "cuDevicePrimaryCtxRetain");
        get(release, "cuDevicePrimaryCtxRelease_v2");
        get(make_current, "cuCtxSetCurrent");
        get(allocate, "cuMemAlloc_v2");
        get(free, "cuMemFree_v2");
        get(to_device, "cuMemcpyHtoD_v2");
        get(from_device, "cuMemcpyDtoH_v2");
        get(fill, "cuMemsetD8_v2");
        get(load, "cuModuleLoadData");
        get(unload, "cuModuleUnload");
        get(function, "cuModuleGetFunction");
        get(set_attribute, "cuFuncSetAttribute");
        get(launch, "cuLaunchKernel");
        get(synchronise, "cuCtxSynchronize");
        get(error_name, "cuGetErrorName");
        found = found && init(0) == success;
    }
};

const Library& library() {
    static const Library opened;
    return opened;
}

DeviceInfo info_of(Ordinal device, std::size_t number) {
    const Library& cuda = library();
    std::array<char, 256> name{};
    std::size_t memory = 0;
    int version = 0;
    (void)cuda.name(name.data(), static_cast<int>(name.size()) - 1, device);
    (void)cuda.memory(&memory, device);
    (void)cuda.version(&version);
    return {.id = fmt::format("cuda:{}", number),
            .name = name.data(),
            .driver = fmt::format("CUDA {}.{}", version / 1000, version % 1000 / 10),
            .memory_bytes = static_cast<double>(memory),
            .largest_buffer_bytes = static_cast<double>(memory),
            .graphics = true};
}

class CudaBuffer : public Buffer {
public:
    CudaBuffer(Context context, Address address, std::size_t bytes) : context_(context), address_(address), bytes_(bytes) {}
    ~CudaBuffer() override {
        (void)library().make_current(context_);
        (void)library().free(address_);
    }
    CudaBuffer(const CudaBuffer&) = delete;
    CudaBuffer& operator=(const CudaBuffer&) = delete;
    [[nodiscard]] std::size_t bytes() const override { return bytes_; }
    [[nodiscard]] Address address() const { return address_; }

private:
    Context context_;
    Address address_;
    std::size_t bytes_;
};
Address address_of(const Buffer& buffer) {
    return dynamic_cast<const CudaBuffer&>(buffer).address();
}

class CudaProgram : public Program {
public:
    CudaProgram(Context context, Module module) : context_(context), module_(module) {}
    ~CudaProgram() override {
        (void)library().make_current(context_);
        (void)library().unload(module_);
    }
    CudaProgram(const CudaProgram&) = delete;
    CudaProgram& operator=(const CudaProgram&) = delete;
    [[nodiscard]] Module module() const { return module_; }
    std::map<std::string, Function> kernels;

private:
    Context context_;
    Module module_;
};

class CudaDevice : public Device {
public:
    CudaDevice(Ordinal device, std::size_t number) : device_(device), info_(info_of(device, number)) {
        require(cuda_.retain(&context_, device_), "cannot be opened");
    }
    ~CudaDevice() override {
        programs_.clear();
        if (context_ != nullptr) (void)cuda_.release(device_);
    }
    CudaDevice(const CudaDevice&) = delete;
    CudaDevice& operator=(const CudaDevice&) = delete;

    [[nodiscard]] const DeviceInfo& info() const override { return info_; }
    [[nodiscard]] std::unique_ptr<Buffer> allocate(std::size_t bytes) override {
        use();
        Address address = 0;
        if (cuda_.allocate(&address, std::max<std::size_t>(bytes, 16)) != success)
            throw MachineError(fmt::format("{} gives no buffer of {:.3g} GB", info_.name, 1e-9 * static_cast<double>(bytes)),
                               {.where = fmt::format("{}, {:.3g} GB of memory", info_.id, 1e-9 * info_.memory_bytes),
                                .fix = "choose a larger voxel size, precision = \"single\", or --device cpu"});
        return std::make_unique<CudaBuffer>(context_, address, bytes);
    }
    void write(Buffer& to, std::size_t byte, std::span<const std::byte> from) override {
        use();
        if (!from.empty()) require(cuda_.to_device(address_of(to) + byte, from.data(), from.size()), "was lost");
    }
    void read(const Buffer& from, std::size_t byte, std::span<std::byte> to) override {
        use();
        if (!to.empty()) require(cuda_.from_device(to.data(), address_of(from) + byte, to.size()), "was lost");
    }
    void fill_with_zeros(Buffer& buffer) override {
        use();
        require(cuda_.fill(address_of(buffer), 0, std::max<std::size_t>(buffer.bytes(), 16)), "was lost");
    }
    [[nodiscard]] std::shared_ptr<Program> compile(const ProgramText& text) override {
        use();
        if (text.ptx == nullptr)  // of populations in pieces, too: CUDA gives one buffer, or the memory is too small
            throw MachineError(info_.name + " has no free piece of memory that is large enough",
                               {.where = info_.id, .fix = "choose a larger voxel size, precision = \"single\", or --device cpu"});
        std::shared_ptr<CudaProgram>& program = programs_[text.ptx];
        if (program) return program;
        Module module = nullptr;
        if (const Result fault = cuda_.load(&module, text.ptx); fault != success)
            throw EngineError(fmt::format("the driver of {} does not take the kernels: {}", info_.name, name_of(fault)),
                              {.where = info_.id + ", " + info_.driver, .fix = "a newer driver, or a device of OpenCL: porepack devices"});
        program = std::make_shared<CudaProgram>(context_, module);
        return program;
    }
    void run(Program& program, const std::string& name, std::size_t groups, std::size_t group_size,
             std::span<const Argument> arguments) override {
        use();
        auto& compiled = dynamic_cast<CudaProgram&>(program);
        Function& kernel = compiled.kernels[name];
        if (kernel == nullptr) require(cuda_.function(&kernel, compiled.module(), name.c_str()), "has not the kernel " + name);
        std::vector<Address> addresses;
        addresses.reserve(arguments.size());
        std::vector<void*> places;
        std::size_t shared = 0;
        for (const Argument& argument : arguments) {
            if (const auto* const* buffer = std::get_if<const Buffer*>(&argument.value)) {
                addresses.push_back(address_of(**buffer));
                places.push_back(&addresses.back());
            } else if (const auto* bytes = std::get_if<Argument::SharedBytes>(&argument.value)) {
                shared = bytes->bytes;
            } else {
                places.push_back(const_cast<std::byte*>(std::get<std::vector<std::byte>>(argument.value).data()));
            }
        }
        constexpr std::size_t without_asking = 48 * 1024;
        if (shared > without_asking)
            require(cuda_.set_attribute(kernel, attribute_of_shared_bytes, static_cast<int>(shared)),
                    "has too little shared memory for " + name);
        require(cuda_.launch(kernel, static_cast<unsigned>(groups), 1, 1, static_cast<unsigned>(group_size), 1, 1,
                             static_cast<unsigned>(shared), nullptr, places.data(), nullptr),
                "cannot run " + name);
    }
    void finish() override {
        use();
        require(cuda_.synchronise(), "was lost");
    }

private:
    // A context belongs to the thread that uses it.
    void use() const { require(cuda_.make_current(context_), "was lost"); }
    [[nodiscard]] std::string name_of(Result fault) const {
        const char* name = nullptr;
        return cuda_.error_name(fault, &name) == success && name != nullptr ? name : fmt::format("error {}", fault);
    }
    void require(Result fault, const std::string& what) const {
        if (fault == success) return;
        throw DeviceLost(fmt::format("the device {} ({}) {}: {}", info_.id, info_.name, what, name_of(fault)),
                         {.fix = "run the same command again: it resumes from its checkpoint; or choose another --device"});
    }

    const Library& cuda_ = library();
    Ordinal device_;
    DeviceInfo info_;
    Context context_ = nullptr;
    std::map<const char*, std::shared_ptr<CudaProgram>> programs_;
};

}  // namespace

std::vector<DeviceInfo> find_devices() {
    std::vector<DeviceInfo> all;
    int count = 0;
    if (!library().found || library().count(&count) != success) return all;
    for (int number = 0; number < count; ++number) {
        Ordinal device = 0;
        if (library().device(&device, number) == success) all.push_back(info_of(device, static_cast<std::size_t>(number)));
    }
    return all;
}

std::shared_ptr<Device> open_device(std::size_t number) {
    int count = 0;
    Ordinal device = 0;
    if (!library().found || library().count(&count) != success || number >= static_cast<std::size_t>(count)) return nullptr;
    if (library().device(&device, static_cast<int>(number)) != success) return nullptr;
    return std::make_shared<CudaDevice>(device, number);
}

}  // namespace porepack::devices::cuda

#else

namespace porepack::devices::cuda {
std::vector<DeviceInfo> find_devices() {
    return {};
}
std::shared_ptr<Device> open_device(std::size_t) {
    return nullptr;
}
}  // namespace porepack::devices::cuda
#endif
