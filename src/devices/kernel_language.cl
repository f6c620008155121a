// What OpenCL C 1.2 and CUDA call differently. A group of threads works on one part of the data; its threads share LOCAL memory.
// LOCAL_ARGUMENT(type, name) is the last argument of a kernel that shares as much memory as its caller says; LOCAL_MEMORY(type, name)
// begins its body.
#if defined(__OPENCL_VERSION__)
#pragma OPENCL EXTENSION cl_khr_fp64 : enable
typedef uchar u8;
typedef ushort u16;
typedef uint u32;
typedef ulong u64;
#define KERNEL(threads) __kernel __attribute__((reqd_work_group_size(threads, 1, 1))) void
#define FUNCTION
#define GLOBAL __global
#define LOCAL __local
#define LOCAL_ARGUMENT(type, name) , __local type* name
#define LOCAL_MEMORY(type, name)
#define BARRIER barrier(CLK_LOCAL_MEM_FENCE)
#define GROUP ((u64)get_group_id(0))
#define GROUPS ((u64)get_num_groups(0))
#define THREAD ((u32)get_local_id(0))
#else
typedef unsigned char u8;
typedef unsigned short u16;
typedef unsigned int u32;
typedef unsigned long long u64;
// Four groups at least per multiprocessor: with no bound, the compiler takes fewer registers than the kernels need.
#define KERNEL(threads) extern "C" __global__ void __launch_bounds__(threads, 4)
#define FUNCTION __device__ static inline
#define GLOBAL
#define LOCAL
#define LOCAL_ARGUMENT(type, name)
#define LOCAL_MEMORY(type, name)                     \
    extern __shared__ double shared_by_the_group[];  \
    type* const name = (type*)shared_by_the_group;
#define BARRIER __syncthreads()
#define GROUP ((u64)blockIdx.x)
#define GROUPS ((u64)gridDim.x)
#define THREAD ((u32)threadIdx.x)
#endif
