# labels: slow
# timeout: 400
"""nvcc compiles the devices' kernel for every architecture of the fat binary, without spilled registers and without
contracted arithmetic; and a multiprocessor of an A100 has room for four blocks.  Skipped without nvcc, which
`.ci/setup --nvcc` fetches."""
import glob
import re
import sysconfig
from e2e import *

BUILD = os.path.dirname(os.path.dirname(os.path.abspath(TMDEMPM)))
TEXT = os.path.join(BUILD, "generated", "rve_kernel.txt")
ARCHITECTURES = (75, 80, 90, 100, 120)
THREADS = 64  # gpu/cuda.c: USUAL_THREADS

# Multiprocessors by the CUDA programming guide's table of compute capabilities: threads, shared memory (kB), of which
# reserved for each block, most for one block.
MULTIPROCESSORS = (("T4", 75, 1024, 64, 0, 64), ("A100", 80, 2048, 164, 1, 163), ("H100", 90, 2048, 228, 1, 227),
                   ("B200", 100, 2048, 228, 1, 227), ("RTX 5090", 120, 1536, 100, 1, 99))

OCCUPANCY = r"""
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <cuda_occupancy.h>
int main(int argc, char **argv)
{
	if (argc != 10)
		return 2;
	int n[10];
	for (int k = 1; k < 10; k++)
		n[k] = atoi(argv[k]);
	cudaOccDeviceProp gpu;
	cudaOccFuncAttributes kernel;
	cudaOccDeviceState state;
	cudaOccResult result;
	memset(&gpu, 0, sizeof gpu), memset(&kernel, 0, sizeof kernel), memset(&state, 0, sizeof state);
	gpu.computeMajor = n[1] / 10, gpu.computeMinor = n[1] % 10;
	gpu.maxThreadsPerBlock = 1024, gpu.maxThreadsPerMultiprocessor = n[2];
	gpu.regsPerBlock = gpu.regsPerMultiprocessor = 65536, gpu.warpSize = 32;
	gpu.sharedMemPerBlock = 49152, gpu.sharedMemPerMultiprocessor = 1024 * n[3];
	gpu.reservedSharedMemPerBlock = 1024 * n[4], gpu.sharedMemPerBlockOptin = 1024 * n[5];
	gpu.numSms = 1;
	kernel.maxThreadsPerBlock = 1024, kernel.numRegs = n[6], kernel.sharedSizeBytes = n[7];
	kernel.maxDynamicSharedSizeBytes = 0, kernel.numBlockBarriers = n[9];
	state.carveoutConfig = 100; /* all that there is as shared memory */
	if (cudaOccMaxActiveBlocksPerMultiprocessor(&result, &gpu, &kernel, &state, n[8], 0) != CUDA_OCC_SUCCESS)
		return 1;
	printf("%d\n", result.activeBlocksPerMultiprocessor);
	return 0;
}
"""


def find_nvcc():
    packages = [sysconfig.get_path("purelib")] + glob.glob(os.path.join(BUILD, "nvcc", "lib", "python3*", "site-packages"))
    wheels = [name for folder in packages for name in glob.glob(os.path.join(folder, "nvidia", "cu1*", "bin", "nvcc"))]
    for name in (os.environ.get("TMDEMPM_NVCC"), shutil.which("nvcc"), "/usr/local/cuda/bin/nvcc", *wheels):
        if name and os.access(name, os.X_OK):
            return name
    return skip("there is no nvcc: .ci/setup --nvcc fetches it")


def output(*command):
    done = subprocess.run(command, capture_output=True, text=True, timeout=300)
    expect(done.returncode == 0, "%s\n%s%s" % (" ".join(command), done.stdout, done.stderr))
    return done.stdout + done.stderr


nvcc = find_nvcc()
if not os.path.exists(TEXT):
    skip("this build has no devices (TMDEMPM_GPU is off)")
with open(os.path.join(SOURCE_DIR, "gpu", "CMakeLists.txt"), encoding="utf-8") as stream:
    sizes = re.findall(r"-DRVE_TASK\w*=\d+", stream.read())
expect(len(sizes) == 2, "gpu/CMakeLists.txt tells nvcc the sizes %s" % sizes)
common = [nvcc, "-x", "cu", "-std=c++17", "-fmad=false", *sizes]
print(output(nvcc, "--version").splitlines()[-1])

with Folder() as f:
    kernels = {}
    for sm in ARCHITECTURES:
        said = output(*common, "-gencode", "arch=compute_%d,code=sm_%d" % (sm, sm), "-Xptxas", "-v", "-cubin",
                      "-o", f("kernel.cubin"), TEXT)
        spills = [int(n) for n in re.findall(r"(\d+) bytes spill", said)]
        expect(spills and not any(spills), "sm_%d: registers are spilled:\n%s" % (sm, said))
        kernels[sm] = [int(re.search(pattern, said).group(1)) for pattern in (r"(\d+) registers", r"(\d+) bytes smem", r"(\d+) barriers")]
    output(*common, "-arch=compute_75", "-ptx", "-o", f("kernel.ptx"), TEXT)
    with open(f("kernel.ptx"), encoding="utf-8") as stream:
        text = stream.read()
    expect("rve_device_advance" in text and "mul" in text and not re.search(r"\b(fma|mad)\.\w+\.f(32|64)", text),
           "multiplications and additions are contracted: other bits than the serial kernel's")

    include = os.path.join(os.path.dirname(os.path.dirname(os.path.realpath(nvcc))), "include")
    if not os.path.exists(os.path.join(include, "cuda_occupancy.h")):
        skip("registers are held; there is no cuda_occupancy.h beside %s" % nvcc)
    f.write("occupancy.cpp", OCCUPANCY)
    output("g++", "-I", include, "-o", f("occupancy"), f("occupancy.cpp"))
    print("blocks of %d threads on a multiprocessor (an estimate by cuda_occupancy.h, not a measurement)" % THREADS)
    blocks = {}
    for name, sm, threads, shared, reserved, most in MULTIPROCESSORS:
        registers, smem, barriers = kernels[sm]
        numbers = [sm, threads, shared, reserved, most, registers, smem, THREADS, barriers]
        blocks[name] = int(output(f("occupancy"), *map(str, numbers)))
        print("%-9s sm_%-4d %d registers, %.1f kB shared: %d blocks" % (name, sm, registers, smem / 1e3, blocks[name]))
    expect(blocks["A100"] >= 4, "an A100's multiprocessor has room for %d blocks" % blocks["A100"])
