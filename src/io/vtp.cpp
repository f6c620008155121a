#include <vtkCellArray.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkXMLPolyDataWriter.h>

#include "core/error.hpp"
#include "io/stl.hpp"

namespace porepack {

void write_vtp(const Path& path, const TriangleSurface& surface) {
    vtkNew<vtkPoints> points;
    points->SetDataTypeToDouble();
    for (const auto& p : surface.points) points->InsertNextPoint(p.data());
    vtkNew<vtkCellArray> cells;
    for (const auto& t : surface.triangles) {
        const vtkIdType corners[3] = {t[0], t[1], t[2]};
        cells->InsertNextCell(3, corners);
    }
    vtkNew<vtkPolyData> data;
    data->SetPoints(points);
    data->SetPolys(cells);
    write_whole(path, [&](const Path& name) {
        vtkNew<vtkXMLPolyDataWriter> writer;
        writer->SetFileName(name.c_str());
        writer->SetInputData(data);
        if (writer->Write() != 1 || writer->GetErrorCode() != 0)
            throw MachineError("cannot write " + path.string(), {.mend = "free some disk space or choose another folder with --output"});
    });
}

}  // namespace porepack
