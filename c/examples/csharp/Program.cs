// Fills the hole of a sphere without its top from C#, in memory. The shared library must be found: see docs/c.md.
using System;
using System.Collections.Generic;
using System.Runtime.InteropServices;

/// A mesh, and what is known of its vertices and faces after a fill.
public sealed class Filled
{
    public double[] Vertices, ExpectedErrors;
    public int[] Faces, FaceOrigins;
    public bool IsComplete;
    public string Report;
}

/// The functions of isomend.h that the example uses.
public static class Isomend
{
    private const string Library = "isomend";
    private const uint AbiVersion = 1;

    [UnmanagedFunctionPointer(CallingConvention.Cdecl)]
    public delegate int Progress(double part, UIntPtr done, UIntPtr all, IntPtr user);

    [StructLayout(LayoutKind.Sequential)]
    private struct Options
    {
        public uint Threads;
        public IntPtr Progress;
        public IntPtr User;
        public IntPtr Cancel;
    }

    [DllImport(Library)] private static extern uint isomend_abi_version();
    [DllImport(Library)] private static extern IntPtr isomend_last_error();
    [DllImport(Library)] private static extern int isomend_mesh_f64(double[] vertices, UIntPtr vertexCount, int[] faces, UIntPtr faceCount, out IntPtr mesh);
    [DllImport(Library)] private static extern void isomend_mesh_free(IntPtr mesh);
    [DllImport(Library)] private static extern int isomend_fill(IntPtr mesh, [MarshalAs(UnmanagedType.LPUTF8Str)] string parameters, ref Options options, out IntPtr result);
    [DllImport(Library)] private static extern UIntPtr isomend_result_vertex_count(IntPtr result);
    [DllImport(Library)] private static extern UIntPtr isomend_result_face_count(IntPtr result);
    [DllImport(Library)] private static extern IntPtr isomend_result_vertices(IntPtr result);
    [DllImport(Library)] private static extern IntPtr isomend_result_faces(IntPtr result);
    [DllImport(Library)] private static extern IntPtr isomend_result_expected_errors(IntPtr result);
    [DllImport(Library)] private static extern IntPtr isomend_result_face_origins(IntPtr result);
    [DllImport(Library)] [return: MarshalAs(UnmanagedType.U1)] private static extern bool isomend_result_is_complete(IntPtr result);
    [DllImport(Library)] private static extern IntPtr isomend_result_report(IntPtr result);
    [DllImport(Library)] private static extern void isomend_result_free(IntPtr result);

    private static void Check(int status)
    {
        if (status == 1) throw new OperationCanceledException();
        if (status != 0) throw new InvalidOperationException(Marshal.PtrToStringUTF8(isomend_last_error()));
    }

    private static double[] Doubles(IntPtr from, int count)
    {
        var array = new double[count];
        if (count > 0) Marshal.Copy(from, array, 0, count);
        return array;
    }

    private static int[] Numbers(IntPtr from, int count)
    {
        var array = new int[count];
        if (count > 0) Marshal.Copy(from, array, 0, count);
        return array;
    }

    /// Fills the holes of a mesh. A new face has the origin -1. The progress function must not throw.
    public static Filled Fill(double[] vertices, int[] faces, string parameters = null, Progress progress = null)
    {
        if (isomend_abi_version() != AbiVersion) throw new InvalidOperationException("isomend has another interface");
        IntPtr mesh = IntPtr.Zero, result = IntPtr.Zero;
        try
        {
            Check(isomend_mesh_f64(vertices, (UIntPtr)(vertices.Length / 3), faces, (UIntPtr)(faces.Length / 3), out mesh));
            var options = new Options { Progress = progress == null ? IntPtr.Zero : Marshal.GetFunctionPointerForDelegate(progress) };
            Check(isomend_fill(mesh, parameters, ref options, out result));
            GC.KeepAlive(progress);
            int vertexCount = (int)isomend_result_vertex_count(result), faceCount = (int)isomend_result_face_count(result);
            return new Filled
            {
                Vertices = Doubles(isomend_result_vertices(result), 3 * vertexCount),
                Faces = Numbers(isomend_result_faces(result), 3 * faceCount),
                ExpectedErrors = Doubles(isomend_result_expected_errors(result), vertexCount),
                FaceOrigins = Numbers(isomend_result_face_origins(result), faceCount),
                IsComplete = isomend_result_is_complete(result),
                Report = Marshal.PtrToStringUTF8(isomend_result_report(result)),
            };
        }
        finally
        {
            isomend_result_free(result);
            isomend_mesh_free(mesh);
        }
    }
}

public static class Program
{
    public static int Main()
    {
        const int rings = 18, around = 24;
        var vertices = new List<double> { 0, 0, -1 };
        var faces = new List<int>();
        for (int ring = 0; ring < rings; ring++)
            for (int i = 0; i < around; i++)
            {
                double latitude = Math.PI * (ring + 1) / 24 - Math.PI / 2, angle = 2 * Math.PI * (i + 0.5 * ring) / around;
                vertices.AddRange(new[] { Math.Cos(latitude) * Math.Cos(angle), Math.Cos(latitude) * Math.Sin(angle), Math.Sin(latitude) });
            }
        for (int i = 0; i < around; i++)
        {
            int next = (i + 1) % around;
            faces.AddRange(new[] { 0, 1 + next, 1 + i });
            for (int ring = 0; ring + 1 < rings; ring++)
            {
                int below = 1 + ring * around, above = below + around;
                faces.AddRange(new[] { below + i, below + next, above + i, below + next, above + next, above + i });
            }
        }
        var filled = Isomend.Fill(vertices.ToArray(), faces.ToArray(), "{\"max_diameter\": 2}", (part, done, all, user) => 0);
        int patch = Array.FindAll(filled.FaceOrigins, origin => origin == -1).Length;
        Console.WriteLine($"{filled.Vertices.Length / 3} vertices, {filled.FaceOrigins.Length} faces, {patch} of them new");
        return filled.IsComplete && patch > 0 ? 0 : 1;
    }
}
